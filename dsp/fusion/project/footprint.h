#pragma once

#include <algorithm>
#include <cstdint>
#include <span>

#include "dsp/base/fixed.h"
#include "dsp/base/kernel.h"
#include "dsp/fusion/project/project.h"

// The area that readings of a row of PMD pixels cover in the left view. Equal lengths, any length,
// any alignment; no overlap.
namespace stof::dsp {

inline constexpr float kFootprintMargin = 0.6F * kPositionOne;
inline constexpr std::int32_t kNoFootprint = -1;

// f_s / f_p / 2 in 1/16 px for a Q15 ray, each above 0.
struct FootprintScale {
  float x = 1;
  float y = 1;
};

// How far a reading reaches to either side of its place, 1/16 px, by IEEE single operations in the
// order of the formula, the fraction dropped:
//   half = min(scale (distance forward / depth) + kFootprintMargin, kFarthestPosition)
// distance: along the ray; forward: Z of the pixel's ray in the PMD camera, Q15; depth: Z in the
// left view. kNoFootprint where distance or depth is none, or forward is not positive.
using HalfSizes = void(std::span<const QuarterMm> distance, std::span<const std::int16_t> forward,
                       std::span<const QuarterMm> depth, const FootprintScale& scale,
                       std::span<std::int32_t> half_x, std::span<std::int32_t> half_y) noexcept;

// Pixels begin .. end - 1 of 0 .. size - 1.
struct PixelRange {
  std::int16_t begin;
  std::int16_t end;
};

// The pixels whose centres lie within `half` of `place` (1/16 px): none of them where begin >= end.
// |place| and half up to kFarthestPosition, size up to 32767.
constexpr PixelRange footprint_range(std::int32_t place, std::int32_t half, int size) noexcept {
  const std::int32_t begin = (place - half + kPositionOne - 1) >> kPositionBits;
  const std::int32_t end = ((place + half) >> kPositionBits) + 1;
  return {static_cast<std::int16_t>(std::clamp(begin, 0, size)),
          static_cast<std::int16_t>(std::clamp(end, 0, size))};
}
static_assert(footprint_range(160, 24, 99).begin == 9 && footprint_range(160, 24, 99).end == 12);

// begin, end = footprint_range(place, half, size); where half is kNoFootprint, begin >= end.
using FootprintRanges = void(std::span<const std::int32_t> place,
                             std::span<const std::int32_t> half, int size,
                             std::span<std::int16_t> begin, std::span<std::int16_t> end) noexcept;

STOF_KERNEL(HalfSizes, half_sizes, kNeon)
STOF_KERNEL(FootprintRanges, footprint_ranges, kNeon)

// The values that a footprint gives every pixel it covers, quarter mm in the left view.
struct FootprintValue {
  QuarterMm visible;  // visible_behind(depth of the reading)
  QuarterMm low;      // interval
  QuarterMm high;
  std::uint8_t flags;  // PmdFlag
};

// The area of a PMD pixel in the left view: columns x_begin .. x_end - 1, rows y_begin .. y_end -
// 1, inside the image and not empty. depth: Z of its reading, quarter mm.
struct Footprint {
  std::int16_t x_begin;
  std::int16_t x_end;
  std::int16_t y_begin;
  std::int16_t y_end;
  QuarterMm depth;
  FootprintValue value;
};

}  // namespace stof::dsp
