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

void cross_means(std::span<const CrossColumn> columns, std::span<const std::uint8_t> here,
                 int lanes, std::span<std::uint8_t> means) noexcept {
  const auto step = static_cast<std::size_t>(lanes);
  STOF_CHECK(means.size() == columns.size() * step && here.size() == means.size());
  for (std::size_t x = 0; x < columns.size(); ++x) {
    const CrossColumn& column = columns[x];
    for (std::size_t i = 0; i < step; ++i) {
      const int sum = column.above[i] + here[x * step + i] + column.below[i];
      means[x * step + i] =
          static_cast<std::uint8_t>(std::min(round_shift(sum * int{column.reciprocal}, 15), 255));
    }
  }
}

}  // namespace stof::dsp::ref
