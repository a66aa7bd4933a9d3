#include "dsp/stereo/validation/peak_ratio.h"

#include <algorithm>
#include <cstddef>
#include <cstdlib>
#include <type_traits>

#include "dsp/base/check.h"
#include "dsp/stereo/cost/sad.h"
#include "dsp/stereo/search/block_winners.h"
#include "dsp/stereo/search/winner.h"

namespace stof::dsp::ref {
namespace {

constexpr std::uint8_t kNothingKnown = 255;

template <typename Sum>
Sum cost_of(Sum sum, [[maybe_unused]] bool numbered) noexcept {
  if constexpr (std::is_same_v<Sum, std::uint16_t>) {
    return numbered ? cost_of_numbered(sum) : sum;
  } else {
    return sum;
  }
}

template <typename Sum>
std::uint8_t ratio_of(std::span<const Sum> costs, bool numbered, int winner) noexcept {
  const Sum cost = cost_of(costs[static_cast<std::size_t>(winner)], numbered);
  Sum rival = kNoCost<Sum>;
  for (int i = 0; i < static_cast<int>(costs.size()); ++i) {
    const Sum other = cost_of(costs[static_cast<std::size_t>(i)], numbered);
    rival = std::abs(i - winner) > 1 ? std::min(rival, other) : rival;
  }
  if (cost == kNoCost<Sum> || rival == kNoCost<Sum> || cost >= rival) {
    return kNothingKnown;
  }
  return static_cast<std::uint8_t>(255.0F * static_cast<float>(cost) / static_cast<float>(rival));
}

}  // namespace

template <typename Sum>
void peak_ratio(std::span<const Sum> costs, int lanes, bool numbered,
                std::span<const std::int16_t> winners, std::span<std::uint8_t> ratio) noexcept {
  const std::size_t count = static_cast<std::size_t>(lanes);
  STOF_CHECK(lanes >= kCostLanes && lanes % kCostLanes == 0 && lanes <= 256 &&
             costs.size() == winners.size() * count && ratio.size() == winners.size());
  STOF_CHECK(!numbered || (std::is_same_v<Sum, std::uint16_t>));
  for (std::size_t x = 0; x < winners.size(); ++x) {
    ratio[x] = winners[x] == kNoWinner
                   ? kNothingKnown
                   : ratio_of(costs.subspan(x * count, count), numbered, winners[x]);
  }
}

STOF_INSTANTIATE(PeakRatio, peak_ratio, std::uint8_t, std::uint16_t, std::uint32_t);

}  // namespace stof::dsp::ref
