#include "dsp/stereo/validation/winner_margin.h"

#include <algorithm>
#include <cstddef>

#include "dsp/base/check.h"

namespace stof::dsp::ref {
namespace {

template <typename Sum>
std::int16_t margin(std::span<const Sum> costs, std::int16_t winner, int percent,
                    int shift) noexcept {
  if (winner == kNoWinner || costs[static_cast<std::size_t>(winner)] == kNoCost<Sum>) {
    return 0;
  }
  std::int64_t sum = 0;
  std::int64_t count = 0;
  for (const Sum cost : costs) {
    if (cost != kNoCost<Sum>) {
      sum += cost;
      ++count;
    }
  }
  const std::int64_t lead = percent * sum - 100 * count * costs[static_cast<std::size_t>(winner)];
  return static_cast<std::int16_t>(
      std::clamp<std::int64_t>(lead >> shift, -32767, 32767));  // floor, as a vector shift does
}

}  // namespace

template <typename Sum>
void winner_margins(std::span<const Sum> costs, int lanes, std::span<const std::int16_t> winners,
                    int percent, int shift, std::span<std::int16_t> margins) noexcept {
  const std::size_t count = static_cast<std::size_t>(lanes);
  STOF_CHECK(lanes >= kCostLanes && lanes % kCostLanes == 0 && lanes <= 256 && shift >= 0 &&
             shift <= 30 && costs.size() == winners.size() * count &&
             margins.size() == winners.size());
  for (std::size_t x = 0; x < winners.size(); ++x) {
    margins[x] = margin(costs.subspan(x * count, count), winners[x], percent, shift);
  }
}

STOF_INSTANTIATE(WinnerMargins, winner_margins, std::uint8_t, std::uint16_t, std::uint32_t);

}  // namespace stof::dsp::ref
