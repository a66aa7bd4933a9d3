#include "dsp/fusion/interval/column_interval.h"

#include <algorithm>
#include <cstddef>

#include "dsp/base/check.h"

namespace stof::dsp::ref {

DepthInterval column_interval_at(std::size_t x, int raw, int half,
                                 const ColumnTables& tables) noexcept {
  if (raw < tables.first_raw || raw > tables.last_raw) {
    return {};
  }
  const std::size_t at =
      x * Disparity::kOne + static_cast<std::size_t>(tables.last_raw - raw + kMostHalfWidth);
  const std::size_t half_width = static_cast<std::size_t>(half);
  const std::int64_t near = std::int64_t{tables.right[at - half_width]} - tables.left[x] + 1;
  const std::int64_t far = std::int64_t{tables.right[at + half_width]} - tables.left[x] - 1;
  const std::int64_t range = tables.max_range;
  if (near <= 0 || tables.near_numerator / near >= range) {
    return {};
  }
  return {static_cast<QuarterMm>(std::max<std::int64_t>(tables.near_numerator / near, 1)),
          static_cast<QuarterMm>(
              far <= 0 ? range : std::min((tables.far_numerator + far - 1) / far, range))};
}

void column_interval(std::span<const Disparity> disparity, std::span<const std::uint8_t> half,
                     const ColumnTables& tables, std::span<QuarterMm> low,
                     std::span<QuarterMm> high) noexcept {
  const std::size_t n = disparity.size();
  STOF_CHECK(tables.left.size() == n && half.size() == n && low.size() == n && high.size() == n);
  STOF_CHECK(tables.first_raw <= tables.last_raw);
  STOF_CHECK(tables.right.size() >= right_tangents(n, tables.first_raw, tables.last_raw));
  for (std::size_t x = 0; x < n; ++x) {
    const DepthInterval interval = disparity[x].valid()
                                       ? column_interval_at(x, disparity[x].raw, half[x], tables)
                                       : DepthInterval{};
    low[x] = interval.low;
    high[x] = interval.high;
  }
}

}  // namespace stof::dsp::ref
