#include "dsp/stereo/cost/sad.h"

#include <cstddef>
#include <cstdlib>

#include "dsp/base/check.h"

namespace stof::dsp::ref {
namespace {

std::size_t index(std::size_t column, std::size_t lane, int lanes) noexcept {
  return column * static_cast<std::size_t>(lanes) + lane;
}

void check_sizes(std::size_t n, std::size_t right, int lanes, std::size_t columns) noexcept {
  STOF_CHECK(lanes >= kCostLanes && lanes % kCostLanes == 0);
  STOF_CHECK(right == n + static_cast<std::size_t>(lanes) - 1);
  STOF_CHECK(columns == n * static_cast<std::size_t>(lanes));
}

template <typename Sum>
void add(std::span<const std::uint8_t> left, std::span<const std::uint8_t> right, int lanes,
         std::span<Sum> columns, int sign) noexcept {
  const std::size_t n = left.size();
  check_sizes(n, right.size(), lanes, columns.size());
  for (std::size_t k = 0; k < n; ++k) {
    for (std::size_t i = 0; i < static_cast<std::size_t>(lanes); ++i) {
      const int difference = std::abs(left[k] - right[n - 1 - k + i]);
      Sum& sum = columns[index(k, i, lanes)];
      sum = static_cast<Sum>(sum + static_cast<Sum>(sign * difference));
    }
  }
}

}  // namespace

template <typename Sum>
void add_differences(std::span<const std::uint8_t> left, std::span<const std::uint8_t> right,
                     int lanes, std::span<Sum> columns) noexcept {
  add(left, right, lanes, columns, 1);
}

template <typename Sum>
void slide_differences(std::span<const std::uint8_t> new_left,
                       std::span<const std::uint8_t> new_right,
                       std::span<const std::uint8_t> old_left,
                       std::span<const std::uint8_t> old_right, int lanes,
                       std::span<Sum> columns) noexcept {
  add(new_left, new_right, lanes, columns, 1);
  add(old_left, old_right, lanes, columns, -1);
}

template <typename Sum>
void block_sums(std::span<const Sum> columns, int block_width, int lanes,
                std::span<Sum> costs) noexcept {
  const std::size_t outputs = costs.size() / static_cast<std::size_t>(lanes);
  STOF_CHECK(lanes >= kCostLanes && lanes % kCostLanes == 0 && block_width >= 1);
  STOF_CHECK(columns.size() ==
             costs.size() + index(static_cast<std::size_t>(block_width) - 1, 0, lanes));
  for (std::size_t x = 0; x < outputs; ++x) {
    for (std::size_t i = 0; i < static_cast<std::size_t>(lanes); ++i) {
      Sum sum = 0;
      for (std::size_t k = x; k < x + static_cast<std::size_t>(block_width); ++k) {
        sum = static_cast<Sum>(sum + columns[index(k, i, lanes)]);
      }
      costs[index(x, i, lanes)] = sum;
    }
  }
}

STOF_INSTANTIATE(AddDifferences, add_differences, std::uint16_t, std::uint32_t);
STOF_INSTANTIATE(SlideDifferences, slide_differences, std::uint16_t, std::uint32_t);
STOF_INSTANTIATE(BlockSums, block_sums, std::uint16_t, std::uint32_t);

}  // namespace stof::dsp::ref
