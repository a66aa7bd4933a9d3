#pragma once

#include <cstdint>
#include <string_view>
#include <vector>

#include "firmware/wire/messages/event.h"
#include "host/client/frame/frame.h"
#include "host/client/raw/raw_exposure.h"
#include "host/recording/topics.h"

namespace stof::recording {

struct TopicMessage {
  Topic topic = Topic::kFrameInfo;
  std::uint32_t sequence = 0;
  std::uint64_t log_time = 0;  // ns since 1970
  Buffer data{};
};
using TopicMessages = std::vector<TopicMessage>;

// The wall clock at the start, which goes on by the monotonic one: times of a recording never step.
class LogClock {
 public:
  LogClock();
  std::uint64_t at(client::Time time) const noexcept;
  std::uint64_t now() const noexcept { return at(client::Time::clock::now()); }

 private:
  client::Time began_;
  std::int64_t wall_ns_;
};

// The frame's depth as sensor_msgs/msg/Image, 16UC1 in whole millimetres, 0 = none.
Buffer encode_depth_mm(const MessageHeader& header, const client::Frame& frame);
// A received frame as messages; of images that are empty none.
void append_frame(TopicMessages& to, const client::Frame& frame, std::uint64_t log_time);
// What a sensor says beside its frames; `beside`: the newest frame.
void append_calibration(TopicMessages& to, const client::Frame& beside, std::uint64_t log_time);
void append_health(TopicMessages& to, wire::Origin origin, const wire::HealthReport& health,
                   std::uint64_t log_time);
void append_event(TopicMessages& to, wire::Origin origin, const wire::EventReport& event,
                  std::uint64_t log_time);

// The settings of a sensor from some frame on: the document, whose CRC-32C frame infos name.
void append_settings(TopicMessages& to, std::string_view document, std::uint64_t log_time);
// What the cameras gave: the edge, then the pictures that are there as a whole.
void append_raw(TopicMessages& to, const client::RawExposure& exposure, std::uint64_t log_time);

// A depth in `unit_um` micrometres as whole millimetres, half up; at most 65,535.
constexpr std::uint16_t millimetres(std::uint16_t depth, std::uint32_t unit_um) noexcept {
  const std::uint64_t mm = (std::uint64_t{depth} * unit_um + 500) / 1000;
  return static_cast<std::uint16_t>(mm > 65535 ? 65535 : mm);
}

}  // namespace stof::recording
