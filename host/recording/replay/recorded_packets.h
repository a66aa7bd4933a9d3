#pragma once

#include <cstddef>
#include <memory>
#include <optional>
#include <vector>

#include "dsp/base/arena.h"
#include "firmware/wire/datagram_sink.h"
#include "firmware/wire/frame/frame_coder.h"
#include "firmware/wire/messages/event.h"
#include "firmware/wire/messages/health.h"
#include "host/recording/recording.h"

namespace stof::recording {

// What was recorded as packets again: pixels, numbers and stamps as they were, the clock
// "recorded", and a session that is none of the sensor's. Streams travel without a further loss.
class RecordedPackets {
 public:
  explicit RecordedPackets(const wire::Origin& origin) : origin_(origin) {}

  // Valid until the next call. None: it was not received as a whole, so that it cannot be sent
  // without inventing pixels; its number is missing then.
  std::optional<wire::Datagrams> frame(const RecordedFrame& frame);
  // Of the frame: empty where it has none.
  std::span<const std::byte> calibration(const RecordedFrame& frame);
  std::span<const std::byte> health(const wire::HealthReport& health);
  std::span<const std::byte> event(const wire::EventReport& event);

 private:
  wire::FrameCoder& coder(const wire::FrameSizes& sizes);
  wire::Header header(wire::PacketType type) const noexcept;

  wire::Origin origin_;
  wire::FrameStamp stamp_{.clock = wire::ClockState::kRecorded};  // of the frame that was sent last
  wire::FrameSizes sizes_{};
  std::vector<std::byte> memory_;
  std::optional<wire::FrameCoder> coder_;
  wire::DatagramBuffer buffer_{};
};

}  // namespace stof::recording
