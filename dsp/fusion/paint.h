#pragma once

#include <cstdint>
#include <span>

#include "dsp/base/fixed.h"
#include "dsp/base/target.h"

// Painting a footprint's segment of one image row. All footprints go through paint_nearest first
// (the z-buffer), then all through paint_interval: so the order of footprints does not matter.
namespace stof::dsp {

inline constexpr QuarterMm kNothingPainted = kMaxQuarterMm;

// nearest[x] = min(nearest[x], depth). Any length, any alignment.
using PaintNearest = void(QuarterMm depth, std::span<QuarterMm> nearest) noexcept;

// What a footprint says about every pixel it covers, quarter mm in the left view.
struct Paint {
  QuarterMm visible;  // visible_behind(depth of the reading)
  QuarterMm low;      // interval
  QuarterMm high;
  std::uint8_t flags;  // PmdFlag
};

// Where paint.visible <= nearest[x], the surface is the nearest or within 2 percent of it:
// intervals and flags unite, low[x] = min(low[x], paint.low), high[x] = max(high[x], paint.high),
// flags[x] |= paint.flags; elsewhere nothing changes. Start with low = kNothingPainted, high = 0,
// flags = 0. Equal lengths, any length, any alignment; no overlap.
using PaintInterval = void(const Paint& paint, std::span<const QuarterMm> nearest,
                           std::span<QuarterMm> low, std::span<QuarterMm> high,
                           std::span<std::uint8_t> flags) noexcept;

// The nearest surface must be at least this deep for one at `depth` to count as the same:
// depth <= 1.02 nearest, rounded up.
constexpr QuarterMm visible_behind(QuarterMm depth) noexcept {
  return static_cast<QuarterMm>((std::uint32_t{depth} * 50 + 50) / 51);
}
static_assert(visible_behind(0) == 0 && visible_behind(102) == 100 && visible_behind(103) == 101);

namespace ref {
PaintNearest paint_nearest;
PaintInterval paint_interval;
}  // namespace ref
namespace neon {
PaintNearest paint_nearest;
PaintInterval paint_interval;
}  // namespace neon

}  // namespace stof::dsp
