#include "dsp/stereo/cost/ad_census.h"

#include <algorithm>
#include <cstddef>
#include <cstdlib>

#include "dsp/base/check.h"
#include "dsp/stereo/cost/hamming.h"

namespace stof::dsp::ref {

void ad_census_costs(const AdCensusRow& left, const AdCensusRow& right, int lanes,
                     std::span<std::uint8_t> costs) noexcept {
  hamming_costs(left.planes, right.planes, kCensus7x7.bits(), lanes, costs);
  const std::size_t count = static_cast<std::size_t>(lanes);
  const std::size_t n = costs.size() / count;
  STOF_CHECK(left.grey.size() == n && right.grey.size() == n + count - 1);
  STOF_CHECK(left.derivative.size() == n && right.derivative.size() == n + count - 1);
  for (std::size_t k = 0; k < n; ++k) {
    for (std::size_t i = 0; i < count; ++i) {
      const std::size_t other = n - 1 - k + i;
      const int grey = std::min(std::abs(left.grey[k] - right.grey[other]), kAdCensusGreyCap);
      const int derivative =
          std::min(std::abs(left.derivative[k] - right.derivative[other]), kAdCensusDerivativeCap);
      std::uint8_t& cost = costs[k * count + i];
      cost = static_cast<std::uint8_t>(2 * cost + (grey + derivative) / 2);
    }
  }
}

}  // namespace stof::dsp::ref
