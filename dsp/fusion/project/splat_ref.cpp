#include "dsp/fusion/project/splat.h"

#include <algorithm>
#include <cstddef>

#include "dsp/base/check.h"

namespace stof::dsp::ref {
namespace {

Rows common(const Footprint& footprint, Rows rows) noexcept {
  return {std::max<int>(footprint.y_begin, rows.begin), std::min<int>(footprint.y_end, rows.end)};
}

template <typename T>
std::span<T> segment(const ImageView<T>& image, const Footprint& footprint, int y) noexcept {
  return image.row(y).subspan(static_cast<std::size_t>(footprint.x_begin),
                              static_cast<std::size_t>(footprint.x_end - footprint.x_begin));
}

}  // namespace

void splat_nearest(std::span<const Footprint> footprints, Rows rows,
                   const ImageView<QuarterMm>& nearest) noexcept {
  for (const Footprint& f : footprints) {
    const Rows some = common(f, rows);
    for (int y = some.begin; y < some.end; ++y) {
      for (QuarterMm& there : segment(nearest, f, y)) {
        there = std::min(there, f.depth);
      }
    }
  }
}

void splat_intervals(std::span<const Footprint> footprints, Rows rows,
                     const SplattedView& view) noexcept {
  for (const Footprint& f : footprints) {
    const Rows some = common(f, rows);
    for (int y = some.begin; y < some.end; ++y) {
      splat_interval(f.value, segment(view.nearest, f, y), segment(view.low, f, y),
                     segment(view.high, f, y), segment(view.flags, f, y));
    }
  }
}

void splat_interval(const FootprintValue& value, std::span<const QuarterMm> nearest,
                    std::span<QuarterMm> low, std::span<QuarterMm> high,
                    std::span<std::uint8_t> flags) noexcept {
  const std::size_t n = nearest.size();
  STOF_CHECK(low.size() == n && high.size() == n && flags.size() == n);
  for (std::size_t x = 0; x < n; ++x) {
    if (value.visible <= nearest[x]) {
      low[x] = std::min(low[x], value.low);
      high[x] = std::max(high[x], value.high);
      flags[x] |= value.flags;
    }
  }
}

}  // namespace stof::dsp::ref
