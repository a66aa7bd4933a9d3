#include "dsp/stereo/cost/cross_aggregation.h"

#include <algorithm>
#include <cstddef>

#include "dsp/base/check.h"
#include "dsp/base/fixed.h"

namespace stof::dsp::ref {

void sum_alike(std::span<const std::uint8_t> costs, std::span<const std::uint8_t> joined, int lanes,
               std::span<std::uint8_t> sums) noexcept {
  const auto step = static_cast<std::size_t>(lanes);
  const std::size_t n = joined.size() - 1;
  STOF_CHECK(costs.size() == n * step && sums.size() == costs.size() && joined.front() == 0 &&
             joined.back() == 0);
  for (std::size_t i = 0; i < costs.size(); ++i) {
    const std::size_t x = i / step;
    const int before = joined[x] != 0 ? costs[i - step] : 0;
    const int after = joined[x + 1] != 0 ? costs[i + step] : 0;
    sums[i] = static_cast<std::uint8_t>(costs[i] + before + after);
  }
}

void cross_means(const CrossRows& rows, int lanes, std::span<std::uint8_t> means) noexcept {
  check_cross_rows(rows, lanes, means.size());
  const auto step = static_cast<std::size_t>(lanes);
  for (std::size_t i = 0; i < means.size(); ++i) {
    const std::size_t x = i / step;
    const int above = rows.with_above[x] != 0 ? rows.above[i] : 0;
    const int below = rows.with_below[x] != 0 ? rows.below[i] : 0;
    const int scaled = (above + rows.here[i] + below) * rows.reciprocals[rows.areas[x]];
    means[i] = static_cast<std::uint8_t>(std::min(round_shift(scaled, 15), 255));
  }
}

}  // namespace stof::dsp::ref
