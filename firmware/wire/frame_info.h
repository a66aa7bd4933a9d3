#pragma once

#include <cstddef>
#include <cstdint>

#include "dsp/fusion/depth_map.h"
#include "firmware/wire/messages/frame_info.h"

namespace stof::wire {

inline constexpr std::size_t kSources = 6;  // values of dsp::Source
inline constexpr std::size_t kCauses = 6;   // values of dsp::Cause
inline constexpr std::size_t kDrifts = 5;   // values of dsp::DriftParameter

constexpr std::uint32_t pixels(const FrameInfo& info, dsp::Source source) noexcept {
  return info.pixels_by_source[static_cast<std::size_t>(source)];
}
constexpr bool significant(const FrameInfo& info, std::size_t drift) noexcept {
  return ((info.drift_significant >> drift) & 1U) != 0;
}

}  // namespace stof::wire
