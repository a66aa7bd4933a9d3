#pragma once

#include <array>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <optional>

#include "dsp/base/fixed.h"
#include "dsp/base/image.h"
#include "dsp/fusion/depth_map.h"
#include "firmware/wire/frame_info.h"
#include "firmware/wire/messages/calibration.h"
#include "firmware/wire/packet.h"

namespace stof::client {

using Time = std::chrono::steady_clock::time_point;
using Duration = std::chrono::steady_clock::duration;
// Networks do not turn round packets that were sent farther apart.
inline constexpr Duration kTurnedRound = std::chrono::milliseconds(250);

using wire::kStreams;

constexpr std::size_t index_of(wire::Stream stream) noexcept {
  return static_cast<std::size_t>(stream) - 1;
}
constexpr std::uint8_t mark_of(wire::Stream stream) noexcept {
  return static_cast<std::uint8_t>(1U << index_of(stream));
}

// Bits of Frame::received.
inline constexpr std::uint8_t kHasDepth = mark_of(wire::Stream::kDepth);
inline constexpr std::uint8_t kHasWidth = mark_of(wire::Stream::kWidth);
inline constexpr std::uint8_t kHasSource = mark_of(wire::Stream::kSource);

// One point of the cloud stream: of its block the pixel whose near bound is nearest.
struct CloudPoint {
  std::int16_t x_mm = 0;              // to the right
  std::int16_t y_mm = 0;              // down
  dsp::QuarterMm depth = 0;           // forward; 0 = no point
  dsp::QuarterMm interval_width = 0;  // depth -+ interval_width / 2

  friend bool operator==(const CloudPoint&, const CloudPoint&) = default;
};
static_assert(sizeof(CloudPoint) == 8);

// One frame as it arrived. What did not arrive is 0 (none) and counted as missing: nothing is ever
// filled in, least of all from another frame. Images of streams that were not sent, or of which
// nothing arrived and whose size is not known either, are empty.
// Views: valid until the next call that may return a frame.
// So many members because each stream and each packet of a frame has its own.
struct Frame {
  wire::Origin origin{};
  wire::FrameStamp stamp{};

  // These five have one size, or are empty.
  dsp::ImageView<const dsp::QuarterMm> depth{};  // Z in the rectified left camera; 0 = none
  dsp::ImageView<const dsp::QuarterMm> interval_width{};  // depth -+ interval_width / 2
  dsp::ImageView<const dsp::Source> source{};  // values above kConflict are of a newer sensor
  // Arrives with source; values above kInterpolated are of a newer sensor.
  dsp::ImageView<const dsp::Cause> cause{};
  dsp::ImageView<const std::uint8_t> received{};  // kHasDepth, kHasWidth, kHasSource

  dsp::ImageView<const dsp::Disparity> disparity{};  // of stereo alone, rectified left picture
  // The samples A0 to A3 as the camera gave them. What did not arrive is 0, as a dark sample is.
  std::array<dsp::ImageView<const std::uint16_t>, 4> pmd{};
  dsp::ImageView<const std::uint8_t> left{};  // grey; what did not arrive is 0
  dsp::ImageView<const std::uint8_t> right{};
  dsp::ImageView<const CloudPoint> cloud{};  // one for each block of FrameInfo::cloud_step pixels

  // By stream: mark_of(stream) is set where the pixel arrived; pmd: the four images below each
  // other.
  std::array<dsp::ImageView<const std::uint8_t>, kStreams> marks{};
  // By stream: pixels that did not arrive; 0 for an empty image.
  std::array<std::uint32_t, kStreams> missing{};
  std::uint32_t packets = 0;            // that the frame was sent in, without parity
  std::uint32_t missing_packets = 0;    // neither arrived nor recovered
  std::uint32_t recovered_packets = 0;  // made of parity

  std::optional<wire::FrameInfo> info{};  // absent when its packet did not arrive
  // The session's newest; absent until the first one arrived (one a second).
  std::optional<wire::CalibrationPacket> calibration{};
  // When they reached this machine: the system's stamp, where it gives one, else when they were
  // read.
  Time first_packet{};
  Time last_packet{};

  bool complete() const noexcept { return missing_packets == 0; }
  std::uint32_t missing_pixels(wire::Stream stream) const noexcept {
    return missing[index_of(stream)];
  }
};

}  // namespace stof::client
