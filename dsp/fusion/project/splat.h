#pragma once

#include <cstdint>
#include <span>

#include "dsp/base/fixed.h"
#include "dsp/base/image.h"
#include "dsp/base/kernel.h"
#include "dsp/fusion/project/footprint.h"

// Writes what PMD pixels see into the left view. All footprints go through splat_nearest first
// (the z-buffer), then all through splat_intervals: so the order of footprints does not matter.
namespace stof::dsp {

inline constexpr QuarterMm kNoSplat = kMaxQuarterMm;

// PMD intervals in the left view. nearest is the z-buffer; low = kNoSplat, high = 0 and
// flags = 0 where no footprint lies. All images have the stereo size.
struct SplattedView {
  ImageView<QuarterMm> nearest;
  ImageView<QuarterMm> low;
  ImageView<QuarterMm> high;
  ImageView<std::uint8_t> flags;  // of all footprints that are visible there, united
};

// The kernels write the given rows of images, which may have any size and stride. Pixels beside a
// footprint in its rows may be written again with what they hold, so rows, not columns, can be
// shared out; nothing outside of the image is touched.

// nearest = min(nearest, depth) in every footprint.
using SplatNearest = void(std::span<const Footprint> footprints, Rows rows,
                          const ImageView<QuarterMm>& nearest) noexcept;

// Where value.visible <= nearest in a footprint, the surface is the nearest or within 2 percent of
// it: intervals and flags unite, low = min(low, value.low), high = max(high, value.high), flags |=
// value.flags; elsewhere nothing changes. Start with low = kNoSplat, high = 0, flags = 0.
using SplatIntervals = void(std::span<const Footprint> footprints, Rows rows,
                            const SplattedView& view) noexcept;

// The same for one segment of one row. Equal lengths, any length, any alignment; no overlap.
using SplatInterval = void(const FootprintValue& value, std::span<const QuarterMm> nearest,
                           std::span<QuarterMm> low, std::span<QuarterMm> high,
                           std::span<std::uint8_t> flags) noexcept;

// The nearest surface must be at least this deep for one at `depth` to count as the same:
// depth <= 1.02 nearest, rounded up.
constexpr QuarterMm visible_behind(QuarterMm depth) noexcept {
  return static_cast<QuarterMm>((std::uint32_t{depth} * 50 + 50) / 51);
}
static_assert(visible_behind(0) == 0 && visible_behind(102) == 100 && visible_behind(103) == 101);

STOF_KERNEL(SplatNearest, splat_nearest, kNeon)
STOF_KERNEL(SplatIntervals, splat_intervals, kNeon)
STOF_KERNEL(SplatInterval, splat_interval, kNeon)

}  // namespace stof::dsp
