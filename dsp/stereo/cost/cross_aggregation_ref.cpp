#include "dsp/stereo/cost/cross_aggregation.h"

#include <algorithm>
#include <cstddef>

#include "dsp/base/check.h"
#include "dsp/base/fixed.h"

namespace stof::dsp::ref {

void sum_along(std::span<const std::uint8_t> costs, int lanes,
               std::span<std::uint16_t> sums) noexcept {
  const auto step = static_cast<std::size_t>(lanes);
  STOF_CHECK(sums.size() == costs.size() + step);
  std::fill_n(sums.begin(), step, std::uint16_t{0});
  for (std::size_t i = 0; i < costs.size(); ++i) {
    sums[i + step] = static_cast<std::uint16_t>(sums[i] + costs[i]);
  }
}

void sum_down(std::span<const std::uint16_t> sums, std::span<const std::uint8_t> left,
              std::span<const std::uint8_t> right, int lanes, std::span<const std::uint16_t> above,
              std::span<std::uint16_t> below) noexcept {
  const auto step = static_cast<std::size_t>(lanes);
  STOF_CHECK(right.size() == left.size() && sums.size() == (left.size() + 1) * step &&
             above.size() == left.size() * step && below.size() == above.size());
  for (std::size_t x = 0; x < left.size(); ++x) {
    const std::size_t begin = (x - left[x]) * step;
    const std::size_t end = (x + right[x] + 1) * step;
    for (std::size_t i = 0; i < step; ++i) {
      const std::size_t at = x * step + i;
      below[at] = static_cast<std::uint16_t>(above[at] + sums[end + i] - sums[begin + i]);
    }
  }
}

void cross_means(std::span<const CrossEnds> ends, int lanes,
                 std::span<std::uint8_t> means) noexcept {
  const auto step = static_cast<std::size_t>(lanes);
  STOF_CHECK(means.size() == ends.size() * step);
  for (std::size_t x = 0; x < ends.size(); ++x) {
    const CrossEnds& end = ends[x];
    for (std::size_t i = x * step; i < (x + 1) * step; ++i) {
      const auto sum = static_cast<std::uint16_t>(end.below[i] - end.above[i]);
      const int mean = round_shift(sum / 2 * int{end.reciprocal}, 15);
      means[i] = static_cast<std::uint8_t>(std::min(mean, 255));
    }
  }
}

}  // namespace stof::dsp::ref
