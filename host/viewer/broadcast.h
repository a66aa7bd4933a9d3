#pragma once

#include <atomic>
#include <chrono>
#include <cstdint>
#include <deque>
#include <memory>
#include <mutex>
#include <optional>
#include <string>

#include "host/viewer/conversation.h"
#include "host/viewer/frame_message.h"

namespace stof::viewer {

// What all pages may see: the newest frame, the newest status, the last events. One thread tells,
// another one's conversations ask.
class Broadcast {
 public:
  using Clock = std::chrono::steady_clock;
  static constexpr std::size_t kMostEvents = 200;
  // A frame that was shown longer ago is not sent: nothing old is served as new.
  static constexpr Clock::duration kMostAge = std::chrono::milliseconds(500);

  // hello: JSON, the first message to each page.
  explicit Broadcast(std::string hello, Clock::duration most_age = kMostAge)
      : hello_(std::move(hello)), most_age_(most_age) {}

  // Whether a page waits for a frame: else none has to be copied.
  bool wanted() const noexcept { return waiting_ > 0; }
  // Whether a page has ever connected.
  bool visited() const noexcept { return visited_; }

  void show(FramePlanes frame);
  void tell_status(std::string json);
  void tell_event(std::string json);

  // Numbers count from 1: what is shown, told, and happened so far.
  struct Newest {
    std::uint64_t number = 0;
    std::shared_ptr<const FramePlanes> frame{};  // none: there is none that is new
    Clock::time_point shown{};
  };
  struct Text {
    std::uint64_t number = 0;
    std::string json{};
  };
  const std::string& hello() const noexcept { return hello_; }
  Newest newest_frame() const;
  Text newest_status() const;
  // The first one after that number.
  std::optional<Text> event_after(std::uint64_t number) const;

  // One page.
  std::unique_ptr<Conversation> open_conversation();

 private:
  friend class PageConversation;

  const std::string hello_;
  const Clock::duration most_age_;
  mutable std::mutex mutex_;
  Newest frame_;
  Text status_;
  std::deque<Text> events_;
  std::atomic<int> waiting_ = 0;  // pages that may be sent a frame
  std::atomic<bool> visited_ = false;
};

}  // namespace stof::viewer
