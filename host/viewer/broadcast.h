#pragma once

#include <array>
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
#include "host/viewer/requests.h"

namespace stof::viewer {

// What all pages are told of, the newest message of each alone.
enum class Topic : std::uint8_t {
  kStatus,
  kSettings,
  kFaults,
  kRecording,
  kPlayback,
  kPairing,
  kUpdate
};
inline constexpr std::size_t kTopics = 7;

// What a page that has connected may have done, and where it is.
struct Visitor {
  std::string why_not{};       // one line: nothing; empty: what follows does not name
  std::string why_not_pair{};  // likewise: no pairing
  std::string place = "this computer";
};

// What all pages may see: the newest frame, what is told of each topic, the last events. Some
// threads tell, another one's conversations ask.
class Broadcast {
 public:
  using Clock = std::chrono::steady_clock;
  static constexpr std::size_t kMostEvents = 200;
  // A frame that was shown longer ago is not sent: nothing old is served as new.
  static constexpr Clock::duration kMostAge = std::chrono::milliseconds(500);

  // hello: JSON, the first message to each page. serve: does what pages want; wake: they have a
  // message, for any thread.
  explicit Broadcast(
      std::string hello, Clock::duration most_age = kMostAge, Serve serve = {},
      std::function<void()> wake = [] {})
      : hello_(std::move(hello)),
        most_age_(most_age),
        serve_(std::move(serve)),
        wake_(std::move(wake)) {}

  // Whether a page waits for a frame: else none has to be copied.
  bool wanted() const noexcept { return waiting_ > 0; }
  // Whether a page has ever connected.
  bool visited() const noexcept { return visited_; }

  void show(FramePlanes frame);
  void tell(Topic topic, std::string json);
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
  Text newest(Topic topic) const;
  // The first one after that number.
  std::optional<Text> event_after(std::uint64_t number) const;

  // One page. Of the server's thread.
  std::unique_ptr<Conversation> open_conversation(const Visitor& visitor = {});

 private:
  friend class PageConversation;

  const std::string hello_;
  const Clock::duration most_age_;
  const Serve serve_;
  const std::function<void()> wake_;
  mutable std::mutex mutex_;
  Newest frame_;
  std::array<Text, kTopics> topics_;
  std::deque<Text> events_;
  std::uint64_t pages_ = 0;       // that have connected
  std::atomic<int> waiting_ = 0;  // pages that may be sent a frame
  std::atomic<bool> visited_ = false;
};

}  // namespace stof::viewer
