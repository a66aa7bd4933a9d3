#pragma once

#include <cstdint>
#include <deque>
#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <utility>

#include "host/viewer/page_message.h"

namespace stof::viewer {

// The connection of a page that wants something done. Copies are of the same one.
struct Page {
  std::uint64_t number = 0;  // from 1; no other connection of this program has it
  std::string place{};       // "this computer", or its address
  std::weak_ptr<const void> there{};

  // Until the connection has ended; for any thread.
  bool connected() const noexcept { return !there.expired(); }
};

// What one page is owed beside what all are told: answers to its requests. For any thread.
class Mailbox {
 public:
  static constexpr int kMostOpen = 8;  // requests without an answer

  // A request more is answered later; false: too many are open.
  bool open_one();
  void close_one(std::string json);
  void put(std::string json);
  std::optional<std::string> take();

 private:
  std::mutex mutex_;
  std::deque<std::string> messages_;
  int open_ = 0;
};

// Answers one request, once, from any thread and at any time; a page that has gone gets none.
class Answer {
 public:
  Answer() = default;
  Answer(std::weak_ptr<Mailbox> to, std::uint32_t id, std::function<void()> wake)
      : to_(std::move(to)), id_(id), wake_(std::move(wake)) {}
  // text: one line; "" where all is said.
  void operator()(bool done, const std::string& text) const;

 private:
  std::weak_ptr<Mailbox> to_;
  std::uint32_t id_ = 0;
  std::function<void()> wake_;
};

// Does what a page wants, or has it done; called by the server's thread, which must not wait. Each
// is answered.
using Serve = std::function<void(const Page& page, Wish, Answer)>;

}  // namespace stof::viewer
