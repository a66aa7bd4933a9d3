#include "dsp/stereo/search/winner.h"

#include <algorithm>
#include <cstddef>

#include "dsp/base/check.h"

namespace stof::dsp::ref {

template <typename Sum>
void winners(std::span<const Sum> costs, int lanes, std::span<std::int16_t> winners) noexcept {
  const std::size_t count = static_cast<std::size_t>(lanes);
  STOF_CHECK(lanes >= kCostLanes && lanes % kCostLanes == 0 &&
             costs.size() == winners.size() * count);
  for (std::size_t x = 0; x < winners.size(); ++x) {
    Sum lowest = kNoCost<Sum>;
    Sum highest = 0;
    std::int16_t winner = kNoWinner;
    for (std::size_t i = 0; i < count; ++i) {
      const Sum cost = costs[x * count + i];
      if (cost < lowest) {
        lowest = cost;
        winner = static_cast<std::int16_t>(i);
      }
      highest = cost == kNoCost<Sum> ? highest : std::max(highest, cost);
    }
    winners[x] = lowest < highest ? winner : kNoWinner;
  }
}

template <typename Sum>
void right_winners(std::span<const Sum> costs, int lanes, std::span<Sum> lowest,
                   std::span<std::int16_t> winners) noexcept {
  const std::size_t count = static_cast<std::size_t>(lanes);
  const std::size_t n = costs.size() / count;
  STOF_CHECK(lanes >= kCostLanes && lanes % kCostLanes == 0 && costs.size() == n * count);
  STOF_CHECK(lowest.size() == n + count - 1 && winners.size() == lowest.size());
  std::ranges::fill(lowest, kNoCost<Sum>);
  std::ranges::fill(winners, kNoWinner);
  for (std::size_t x = 0; x < n; ++x) {  // a given j meets its candidates in ascending order
    for (std::size_t i = 0; i < count; ++i) {
      const std::size_t j = n - 1 - x + i;
      if (costs[x * count + i] < lowest[j]) {
        lowest[j] = costs[x * count + i];
        winners[j] = static_cast<std::int16_t>(i);
      }
    }
  }
}

STOF_INSTANTIATE(Winners, winners, std::uint8_t, std::uint16_t, std::uint32_t);
STOF_INSTANTIATE(RightWinners, right_winners, std::uint8_t, std::uint16_t, std::uint32_t);

}  // namespace stof::dsp::ref
