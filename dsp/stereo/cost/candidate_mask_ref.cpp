#include "dsp/stereo/cost/candidate_mask.h"

#include <algorithm>
#include <cstddef>

#include "dsp/base/check.h"
#include "dsp/stereo/search/winner.h"

namespace stof::dsp {

bool narrows(GuideRow guide, int candidates) noexcept {
  return std::ranges::any_of(
      guide, [&](Candidates may) noexcept { return may.first > 0 || may.last < candidates - 1; });
}

void keep_guided(GuideRow guide, std::span<std::int16_t> winners) noexcept {
  STOF_CHECK(guide.empty() || guide.size() == winners.size());
  for (std::size_t x = 0; x < guide.size(); ++x) {
    const bool may = winners[x] >= guide[x].first && winners[x] <= guide[x].last;
    winners[x] = may ? winners[x] : kNoWinner;
  }
}

namespace ref {

template <typename Sum>
void mask_candidates(std::span<const Sum> costs, GuideRow guide, int lanes,
                     std::span<Sum> out) noexcept {
  STOF_CHECK(lanes >= kCostLanes && lanes % kCostLanes == 0 && lanes <= 256 &&
             costs.size() == guide.size() * static_cast<std::size_t>(lanes) &&
             out.size() == costs.size());
  std::size_t at = 0;
  for (const Candidates may : guide) {
    for (int i = 0; i < lanes; ++i, ++at) {
      out[at] = i + 1 >= may.first && i - 1 <= may.last ? costs[at] : kNoCost<Sum>;
    }
  }
}

STOF_INSTANTIATE(MaskCandidates, mask_candidates, std::uint8_t, std::uint16_t, std::uint32_t);

}  // namespace ref
}  // namespace stof::dsp
