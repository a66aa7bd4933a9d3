#pragma once

#include <array>
#include <atomic>
#include <chrono>
#include <cstdint>
#include <functional>
#include <memory>
#include <mutex>
#include <string>

#include "host/bridge/robot_feed.h"
#include "host/viewer/conversation.h"

namespace stof::viewer {

// The newest message of each topic, for clients of the Foxglove protocol: a client gets the newest
// that it has not got, so that nothing queues for a slow one. One thread publishes, another one's
// conversations ask.
class FoxgloveChannels : public bridge::TopicSink {
 public:
  using Clock = std::chrono::steady_clock;

  // name: what clients show of the server. most_age: a frame's message that was published longer
  // ago is not sent. wake: there is something to send, for any thread.
  FoxgloveChannels(std::string name, Clock::duration most_age, std::function<void()> wake);

  // Whether a client has subscribed.
  bool wanted(bridge::Topic topic) override;
  bool publish(bridge::Topic topic, recording::Buffer&& message) override;

  // Whether a client has ever connected.
  bool visited() const noexcept { return visited_; }

  std::unique_ptr<Conversation> open_conversation();

 private:
  friend class FoxgloveConversation;

  struct Newest {
    std::uint64_t number = 0;  // counts from 1
    std::shared_ptr<const recording::Buffer> message{};
    std::uint64_t time_ns = 0;  // since 1970
    Clock::time_point published{};
  };
  // Without a message where there is none that is new.
  Newest newest(bridge::Topic topic) const;

  const std::string server_info_;
  const std::string advertise_;
  const Clock::duration most_age_;
  const std::function<void()> wake_;
  mutable std::mutex mutex_;
  std::array<Newest, bridge::kTopics> newest_;
  std::array<std::atomic<int>, bridge::kTopics> subscribers_{};
  std::atomic<bool> visited_ = false;
};

}  // namespace stof::viewer
