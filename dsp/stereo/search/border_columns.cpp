#include "dsp/stereo/search/border_columns.h"

#include <algorithm>
#include <cstddef>

#include "dsp/stereo/search/winner.h"

namespace stof::dsp {

void match_border_columns(int min_disparity, int disparities,
                          std::span<std::int16_t> winners) noexcept {
  const int width = static_cast<int>(winners.size());
  const auto accept = [&](int x, int neighbour, int candidate) noexcept {
    if (std::min(x, neighbour) >= 0 && std::max(x, neighbour) < width &&
        winners[static_cast<std::size_t>(neighbour)] != kNoWinner) {
      winners[static_cast<std::size_t>(x)] = static_cast<std::int16_t>(candidate);
    }
  };
  if (disparities > 1) {
    accept(min_disparity, min_disparity + 1, 0);  // meets right column 0 as candidate 0
    const int last = width + min_disparity + disparities - 2;  // meets the last one
    accept(last, last - 1, disparities - 1);
  }
}

void finish_winners(const MatchParams& params, GuideRow guide,
                    std::span<std::int16_t> winners) noexcept {
  keep_guided(guide, winners);
  match_border_columns(params.min_disparity, params.disparities, winners);
  keep_guided(guide, winners);
}

}  // namespace stof::dsp
