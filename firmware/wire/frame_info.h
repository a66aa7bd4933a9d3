#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

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

inline constexpr std::size_t kDrifts = std::tuple_size_v<decltype(FrameInfo::drifts)>;

constexpr std::uint32_t pixels(const FrameInfo& info, dsp::Source source) noexcept {
  return info.pixels_by_source[static_cast<std::size_t>(source)];
}
constexpr bool significant(const FrameInfo& info, std::size_t drift) noexcept {
  return ((info.drift_significant >> drift) & 1U) != 0;
}

}  // namespace stof::wire
