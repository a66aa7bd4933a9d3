#include "dsp/fusion/column_interval.h"

#include <algorithm>
#include <cstddef>

#include "dsp/base/check.h"

namespace stof::dsp::ref {

void column_interval(std::span<const Disparity> disparity, const ColumnTables& tables,
                     std::span<QuarterMm> low, std::span<QuarterMm> high) noexcept {
  const std::size_t n = disparity.size();
  STOF_CHECK(tables.left.size() == n && low.size() == n && high.size() == n);
  STOF_CHECK(tables.first_raw <= tables.last_raw && tables.sigma_raw >= 0);
  STOF_CHECK(tables.right.size() >=
             right_tangents(n, tables.first_raw, tables.last_raw, tables.sigma_raw));
  const std::size_t between_ends = 4 * static_cast<std::size_t>(tables.sigma_raw);
  const std::int64_t range = tables.max_range;
  for (std::size_t x = 0; x < n; ++x) {
    low[x] = 0;
    high[x] = 0;
    const int raw = disparity[x].raw;
    if (!disparity[x].valid() || raw < tables.first_raw || raw > tables.last_raw) {
      continue;
    }
    const std::size_t at = x * Disparity::kOne + static_cast<std::size_t>(tables.last_raw - raw);
    const std::int64_t near = std::int64_t{tables.right[at]} - tables.left[x] + 1;
    const std::int64_t far = std::int64_t{tables.right[at + between_ends]} - tables.left[x] - 1;
    if (near <= 0 || tables.near_numerator / near >= range) {
      continue;
    }
    low[x] = static_cast<QuarterMm>(std::max<std::int64_t>(tables.near_numerator / near, 1));
    high[x] = static_cast<QuarterMm>(
        far <= 0 ? range : std::min((tables.far_numerator + far - 1) / far, range));
  }
}

}  // namespace stof::dsp::ref
