#include "lab/cost/ssd.h"

#include <cstddef>

#include "dsp/base/check.h"

namespace stof::dsp::ref {
namespace {

template <typename Sum>
void add(std::span<const std::uint8_t> left, std::span<const std::uint8_t> right, int lanes,
         std::span<Sum> columns, int sign) noexcept {
  const std::size_t n = left.size();
  const std::size_t count = static_cast<std::size_t>(lanes);
  STOF_CHECK(lanes >= kCostLanes && lanes % kCostLanes == 0);
  STOF_CHECK(right.size() == n + count - 1 && columns.size() == n * count);
  for (std::size_t k = 0; k < n; ++k) {
    for (std::size_t i = 0; i < count; ++i) {
      const int difference = left[k] - right[n - 1 - k + i];
      Sum& sum = columns[k * count + i];
      sum = static_cast<Sum>(sum + static_cast<Sum>(sign * difference * difference));
    }
  }
}

}  // namespace

template <typename Sum>
void add_squares(std::span<const std::uint8_t> left, std::span<const std::uint8_t> right, int lanes,
                 std::span<Sum> columns) noexcept {
  add(left, right, lanes, columns, 1);
}

template <typename Sum>
void slide_squares(std::span<const std::uint8_t> new_left, std::span<const std::uint8_t> new_right,
                   std::span<const std::uint8_t> old_left, std::span<const std::uint8_t> old_right,
                   int lanes, std::span<Sum> columns) noexcept {
  add(new_left, new_right, lanes, columns, 1);
  add(old_left, old_right, lanes, columns, -1);
}

STOF_INSTANTIATE(AddDifferences, add_squares, std::uint16_t, std::uint32_t);
STOF_INSTANTIATE(SlideDifferences, slide_squares, std::uint16_t, std::uint32_t);

}  // namespace stof::dsp::ref
