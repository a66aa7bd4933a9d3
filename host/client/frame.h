#pragma once

#include <array>
#include <chrono>
#include <cstdint>
#include <optional>

#include "dsp/base/fixed.h"
#include "dsp/base/image.h"
#include "dsp/fusion/fuser.h"
#include "firmware/wire/calibration_packet.h"
#include "firmware/wire/frame_info.h"
#include "firmware/wire/packet.h"

namespace stof::client {

using Time = std::chrono::steady_clock::time_point;
using Duration = std::chrono::steady_clock::duration;

// Bits of Frame::received.
inline constexpr std::uint8_t kHasDepth = 1 << 0;
inline constexpr std::uint8_t kHasWidth = 1 << 1;
inline constexpr std::uint8_t kHasSource = 1 << 2;

// One frame as it arrived. All images have one size; what did not arrive is 0 (none) and its bit in
// `received` is 0: nothing is ever filled in, least of all from another frame.
// Views: valid until the next call that may return a frame.
struct Frame {
  wire::Origin origin{};
  wire::FrameStamp stamp{};
  dsp::ImageView<const dsp::QuarterMm> depth{};  // Z in the rectified left camera; 0 = none
  dsp::ImageView<const dsp::QuarterMm> width{};  // of the interval depth +- width / 2
  dsp::ImageView<const dsp::Source> source{};    // values above kConflict are of a newer sensor
  dsp::ImageView<const std::uint8_t> received{};
  std::uint32_t missing_depth = 0;  // pixels of each image that did not arrive
  std::uint32_t missing_width = 0;
  std::uint32_t missing_source = 0;
  std::uint32_t packets = 0;  // that the frame was sent in
  std::uint32_t missing_packets = 0;
  std::optional<wire::FrameInfo> info{};  // absent when its packet did not arrive
  // The session's newest; absent until the first one arrived (one a second).
  std::optional<wire::CalibrationPacket> calibration{};
  Time first_packet{};  // when this machine read them
  Time last_packet{};

  bool complete() const noexcept { return missing_packets == 0; }
};

}  // namespace stof::client
