#include "dsp/stereo/search/numbered_right_winners.h"

#include <algorithm>
#include <cstddef>

#include "dsp/base/check.h"
#include "dsp/stereo/search/block_winners.h"

namespace stof::dsp::ref {

void numbered_right_winners(std::span<const std::uint16_t> costs, int lanes,
                            std::span<std::int16_t> winners) noexcept {
  const std::size_t count = static_cast<std::size_t>(lanes);
  STOF_CHECK(lanes >= kCostLanes && lanes % kCostLanes == 0 && lanes <= 256);
  const std::size_t n = costs.size() / count;
  STOF_CHECK(n >= 1 && costs.size() == n * count && winners.size() == n + count - 1);
  for (std::size_t j = 0; j < winners.size(); ++j) {
    std::uint16_t lowest = kNoCost<std::uint16_t>;
    winners[j] = kNoWinner;
    // It meets column n - 1 - j + i.
    for (std::size_t i = j < n ? 0 : j + 1 - n; i <= std::min(j, count - 1); ++i) {
      const std::uint16_t cost = cost_of_numbered(costs[(n - 1 - j + i) * count + i]);
      if (cost < lowest) {
        lowest = cost;
        winners[j] = static_cast<std::int16_t>(i);
      }
    }
  }
}

}  // namespace stof::dsp::ref
