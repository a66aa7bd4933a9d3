#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

#include "dsp/fusion/depth_map.h"
#include "firmware/wire/messages/frame_info.h"

namespace stof::wire {

// What a frame stands on.
enum Sensors : std::uint8_t { kNoSensor = 0, kStereoSensor = 1, kPmdSensor = 2, kBothSensors = 3 };

// A sensor of before the field `sensors` always had the pair.
constexpr Sensors sensors_of(const FrameInfo& info) noexcept {
  if (info.sensors == kNoSensor) {
    return info.pmd_present != 0 ? kBothSensors : kStereoSensor;
  }
  return static_cast<Sensors>(info.sensors & kBothSensors);
}

// Also that of a sensor or a recording of before frames told range and period: zeros then.
inline Result<FrameInfo> read_frame_info(std::span<const std::byte> payload) noexcept {
  constexpr std::size_t kBefore = 244;
  if (payload.size() < kBefore || payload.size() >= kFrameInfoBytes) {
    return decode_frame_info(payload);
  }
  std::array<std::byte, kFrameInfoBytes> whole{};
  std::ranges::copy(payload.first(kBefore), whole.begin());
  return decode_frame_info(whole);
}

inline constexpr std::size_t kDrifts = std::tuple_size_v<decltype(FrameInfo::drifts)>;

constexpr std::uint32_t pixels(const FrameInfo& info, dsp::Source source) noexcept {
  return info.pixels_by_source[static_cast<std::size_t>(source)];
}
constexpr bool significant(const FrameInfo& info, std::size_t drift) noexcept {
  return ((info.drift_significant >> drift) & 1U) != 0;
}

}  // namespace stof::wire
