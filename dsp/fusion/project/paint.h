#pragma once

#include <cstdint>
#include <span>

#include "dsp/base/fixed.h"
#include "dsp/base/image.h"
#include "dsp/base/kernel.h"

// Painting what PMD pixels cover into the left view. All footprints go through paint_nearest first
// (the z-buffer), then all through paint_intervals: so the order of footprints does not matter.
namespace stof::dsp {

inline constexpr QuarterMm kNothingPainted = kMaxQuarterMm;

// What a footprint says about every pixel it covers, quarter mm in the left view.
struct Paint {
  QuarterMm visible;  // visible_behind(depth of the reading)
  QuarterMm low;      // interval
  QuarterMm high;
  std::uint8_t flags;  // PmdFlag
};

// What a PMD pixel covers in the left view: columns x_begin .. x_end - 1, rows y_begin .. y_end -
// 1, inside the image and not empty. depth: Z of its reading, quarter mm.
struct Footprint {
  std::int16_t x_begin;
  std::int16_t x_end;
  std::int16_t y_begin;
  std::int16_t y_end;
  QuarterMm depth;
  Paint paint;
};

// PMD intervals in the left view. nearest is the z-buffer; low = kNothingPainted, high = 0 and
// flags = 0 where no footprint lies. All images have the stereo size.
struct PaintedView {
  ImageView<QuarterMm> nearest;
  ImageView<QuarterMm> low;
  ImageView<QuarterMm> high;
  ImageView<std::uint8_t> flags;  // of all footprints that are visible there, united
};

// The kernels write the given rows of images, which may have any size and stride. Pixels beside a
// footprint in its rows may be written again with what they hold, so rows, not columns, can be
// shared out; nothing outside of the image is touched.

// nearest = min(nearest, depth) in every footprint.
using PaintNearest = void(std::span<const Footprint> footprints, Rows rows,
                          const ImageView<QuarterMm>& nearest) noexcept;

// Where paint.visible <= nearest in a footprint, the surface is the nearest or within 2 percent of
// it: intervals and flags unite, low = min(low, paint.low), high = max(high, paint.high), flags |=
// paint.flags; elsewhere nothing changes. Start with low = kNothingPainted, high = 0, flags = 0.
using PaintIntervals = void(std::span<const Footprint> footprints, Rows rows,
                            const PaintedView& view) noexcept;

// The same for one segment of one row. Equal lengths, any length, any alignment; no overlap.
using PaintInterval = void(const Paint& paint, std::span<const QuarterMm> nearest,
                           std::span<QuarterMm> low, std::span<QuarterMm> high,
                           std::span<std::uint8_t> flags) noexcept;

// The nearest surface must be at least this deep for one at `depth` to count as the same:
// depth <= 1.02 nearest, rounded up.
constexpr QuarterMm visible_behind(QuarterMm depth) noexcept {
  return static_cast<QuarterMm>((std::uint32_t{depth} * 50 + 50) / 51);
}
static_assert(visible_behind(0) == 0 && visible_behind(102) == 100 && visible_behind(103) == 101);

STOF_KERNEL(PaintNearest, paint_nearest, kNeon)
STOF_KERNEL(PaintIntervals, paint_intervals, kNeon)
STOF_KERNEL(PaintInterval, paint_interval, kNeon)

}  // namespace stof::dsp
