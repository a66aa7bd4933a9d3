#include "dsp/stereo/cost/sad.h"

#include <cstddef>
#include <cstdlib>

#include "dsp/base/check.h"

namespace stof::dsp::ref {

template <typename Sum>
void add_differences(std::span<const std::uint8_t> left, std::span<const std::uint8_t> right,
                     int lanes, std::span<Sum> columns) noexcept {
  const std::size_t n = left.size();
  const std::size_t count = static_cast<std::size_t>(lanes);
  STOF_CHECK(lanes >= kCostLanes && lanes % kCostLanes == 0);
  STOF_CHECK(right.size() == n + count - 1 && columns.size() == n * count);
  for (std::size_t k = 0; k < n; ++k) {
    for (std::size_t i = 0; i < count; ++i) {
      Sum& sum = columns[k * count + i];
      sum = static_cast<Sum>(sum + static_cast<Sum>(std::abs(left[k] - right[n - 1 - k + i])));
    }
  }
}

STOF_INSTANTIATE(AddDifferences, add_differences, std::uint16_t, std::uint32_t);

}  // namespace stof::dsp::ref
