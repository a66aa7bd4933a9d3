#include "dsp/stereo/cost/hamming.h"

#include <bit>
#include <cstddef>

#include "dsp/base/check.h"

namespace stof::dsp::ref {

void hamming_costs(std::span<const std::uint8_t> left, std::span<const std::uint8_t> right,
                   int bits, int lanes, std::span<std::uint8_t> costs) noexcept {
  STOF_CHECK(bits == kCensus5x5.bits() || bits == kCensus9x7.bits());
  STOF_CHECK(lanes >= kCostLanes && lanes % kCostLanes == 0 && !costs.empty());
  const std::size_t count = static_cast<std::size_t>(lanes);
  const std::size_t n = costs.size() / count;
  const std::size_t planes = planes_of(bits);
  STOF_CHECK(costs.size() == n * count && left.size() == planes * n &&
             right.size() == planes * (n + count - 1));
  for (std::size_t k = 0; k < n; ++k) {
    for (std::size_t i = 0; i < count; ++i) {
      int distance = 0;
      for (std::size_t p = 0; p < planes; ++p) {
        const unsigned difference =
            static_cast<unsigned>(left[p * n + k] ^ right[p * (n + count - 1) + n - 1 - k + i]);
        distance += std::popcount(difference);
      }
      costs[k * count + i] = static_cast<std::uint8_t>(distance);
    }
  }
}

}  // namespace stof::dsp::ref
