#include "lab/cost/cost_sums.h"

#include <cstddef>
#include <cstdlib>

#include "dsp/base/check.h"
#include "dsp/stereo/cost/sad.h"

namespace stof::dsp::ref {

template <typename Sum>
void slide_differences(std::span<const std::uint8_t> new_left,
                       std::span<const std::uint8_t> new_right,
                       std::span<const std::uint8_t> old_left,
                       std::span<const std::uint8_t> old_right, int lanes,
                       std::span<Sum> columns) noexcept {
  const std::size_t n = new_left.size();
  const std::size_t count = static_cast<std::size_t>(lanes);
  STOF_CHECK(columns.size() == n * count && new_right.size() == n + count - 1);
  STOF_CHECK(old_left.size() == n && old_right.size() == new_right.size());
  for (std::size_t k = 0; k < n; ++k) {
    for (std::size_t i = 0; i < count; ++i) {
      const std::size_t at = n - 1 - k + i;
      const int change =
          std::abs(new_left[k] - new_right[at]) - std::abs(old_left[k] - old_right[at]);
      Sum& sum = columns[k * count + i];
      sum = static_cast<Sum>(sum + static_cast<Sum>(change));
    }
  }
}

template <typename Sum>
void block_sums(std::span<const Sum> columns, int block_width, int lanes,
                std::span<Sum> costs) noexcept {
  const std::size_t count = static_cast<std::size_t>(lanes);
  const std::size_t block = static_cast<std::size_t>(block_width);
  STOF_CHECK(lanes >= kCostLanes && lanes % kCostLanes == 0 && block_width >= 1);
  STOF_CHECK(columns.size() == costs.size() + (block - 1) * count);
  for (std::size_t x = 0; x < costs.size() / count; ++x) {
    for (std::size_t i = 0; i < count; ++i) {
      Sum sum = 0;
      for (std::size_t k = x; k < x + block; ++k) {
        sum = static_cast<Sum>(sum + columns[k * count + i]);
      }
      costs[x * count + i] = sum;
    }
  }
}

template <typename Sum>
void add_costs(std::span<const std::uint8_t> costs, std::span<Sum> columns) noexcept {
  STOF_CHECK(costs.size() == columns.size() && costs.size() % kCostLanes == 0);
  for (std::size_t j = 0; j < columns.size(); ++j) {
    columns[j] = static_cast<Sum>(columns[j] + costs[j]);
  }
}

template <typename Sum>
void slide_costs(std::span<const std::uint8_t> entering, std::span<const std::uint8_t> leaving,
                 std::span<Sum> columns) noexcept {
  STOF_CHECK(entering.size() == columns.size() && leaving.size() == columns.size() &&
             columns.size() % kCostLanes == 0);
  for (std::size_t j = 0; j < columns.size(); ++j) {
    columns[j] = static_cast<Sum>(columns[j] + entering[j] - leaving[j]);
  }
}

STOF_INSTANTIATE(SlideDifferences, slide_differences, std::uint16_t, std::uint32_t);
STOF_INSTANTIATE(BlockSums, block_sums, std::uint16_t, std::uint32_t);
STOF_INSTANTIATE(AddCosts, add_costs, std::uint16_t, std::uint32_t);
STOF_INSTANTIATE(SlideCosts, slide_costs, std::uint16_t, std::uint32_t);

}  // namespace stof::dsp::ref
