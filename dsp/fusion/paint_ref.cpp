#include "dsp/fusion/paint.h"

#include <algorithm>
#include <cstddef>

#include "dsp/base/check.h"

namespace stof::dsp::ref {

void paint_nearest(QuarterMm depth, std::span<QuarterMm> nearest) noexcept {
  for (QuarterMm& there : nearest) {
    there = std::min(there, depth);
  }
}

void paint_interval(const Paint& paint, std::span<const QuarterMm> nearest,
                    std::span<QuarterMm> low, std::span<QuarterMm> high,
                    std::span<std::uint8_t> flags) noexcept {
  const std::size_t n = nearest.size();
  STOF_CHECK(low.size() == n && high.size() == n && flags.size() == n);
  for (std::size_t x = 0; x < n; ++x) {
    if (paint.visible <= nearest[x]) {
      low[x] = std::min(low[x], paint.low);
      high[x] = std::max(high[x], paint.high);
      flags[x] |= paint.flags;
    }
  }
}

}  // namespace stof::dsp::ref
