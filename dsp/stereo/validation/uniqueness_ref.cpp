#include "dsp/stereo/validation/uniqueness.h"

#include <cstddef>
#include <cstdlib>

#include "dsp/base/check.h"

namespace stof::dsp::ref {
namespace {

template <typename Sum>
bool unique(std::span<const Sum> costs, int winner, int percent) noexcept {
  const Sum limit = uniqueness_limit(costs[static_cast<std::size_t>(winner)], percent);
  for (int i = 0; i < static_cast<int>(costs.size()); ++i) {
    if (std::abs(i - winner) > 1 && costs[static_cast<std::size_t>(i)] < limit) {
      return false;
    }
  }
  return true;
}

}  // namespace

template <typename Sum>
void uniqueness_check(std::span<const Sum> costs, int lanes, int percent,
                      std::span<std::int16_t> winners) noexcept {
  const std::size_t count = static_cast<std::size_t>(lanes);
  STOF_CHECK(lanes >= kCostLanes && lanes % kCostLanes == 0 && lanes <= 256 && percent >= 0 &&
             percent <= 1000 && costs.size() == winners.size() * count);
  for (std::size_t x = 0; x < winners.size(); ++x) {
    if (winners[x] == kNoWinner) {
      continue;
    }
    const std::span<const Sum> pixel = costs.subspan(x * count, count);
    if (pixel[static_cast<std::size_t>(winners[x])] != kNoCost<Sum> &&
        !unique(pixel, winners[x], percent)) {
      winners[x] = kNoWinner;
    }
  }
}

STOF_INSTANTIATE(UniquenessCheck, uniqueness_check, std::uint8_t, std::uint16_t, std::uint32_t);

}  // namespace stof::dsp::ref
