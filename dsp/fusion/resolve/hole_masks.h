#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

#include "dsp/base/fixed.h"
#include "dsp/base/kernel.h"
#include "dsp/fusion/depth_map.h"

namespace stof::dsp {

// A row of a map, and its matches.
struct HoleRow {
  std::span<const QuarterMm> depth;
  std::span<const QuarterMm> width;
  std::span<const Source> source;
  std::span<const Cause> cause;
  std::span<const Disparity> disparity;
};

// Pixels that HoleFiller may fill. One bit for each, 64 a word, the first lowest; bits behind the
// last pixel are 0.
//   hole   kNone, or kConflict by kMixedPixel
//   loose  kPmd with width kNarrowShare > depth - width / 2, or kResolved by kMixedPixel without a
//          disparity
// and those that it may drop:
//   guess  kPmd as above, or kResolved by kMixedPixel, kStereoAmbiguous or kOccluded
struct HoleMasks {
  std::span<std::uint64_t> hole;
  std::span<std::uint64_t> loose;
  std::span<std::uint64_t> guess;
};

// Equal lengths n of the row, (n + 63) / 64 words each; any alignment; no overlap.
using HoleMasksKernel = void(const HoleRow& row, const HoleMasks& masks) noexcept;

STOF_KERNEL(HoleMasksKernel, hole_masks, kAvx2)

// Lengths as above.
void check_hole_masks(const HoleRow& row, const HoleMasks& masks) noexcept;

// The pixels from x on, x a multiple of 64.
inline HoleRow behind(const HoleRow& row, std::size_t x) noexcept {
  return {row.depth.subspan(x), row.width.subspan(x), row.source.subspan(x), row.cause.subspan(x),
          row.disparity.subspan(x)};
}
inline HoleMasks behind(const HoleMasks& masks, std::size_t x) noexcept {
  return {masks.hole.subspan(x / 64), masks.loose.subspan(x / 64), masks.guess.subspan(x / 64)};
}

}  // namespace stof::dsp
