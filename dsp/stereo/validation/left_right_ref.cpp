#include "dsp/stereo/validation/left_right.h"

#include <cstddef>
#include <cstdlib>

#include "dsp/base/check.h"
#include "dsp/stereo/search/winner.h"

namespace stof::dsp::ref {

void left_right_check(std::span<const std::int16_t> right_winners, int tolerance,
                      std::span<std::int16_t> winners) noexcept {
  STOF_CHECK(tolerance >= 0 && right_winners.size() >= winners.size());
  const std::size_t n = winners.size();
  for (std::size_t x = 0; x < n; ++x) {
    const std::int16_t winner = winners[x];
    if (winner == kNoWinner) {
      continue;
    }
    const std::size_t match = n - 1 - x + static_cast<std::size_t>(winner);
    STOF_CHECK(match < right_winners.size());
    const std::int16_t back = right_winners[match];
    if (back == kNoWinner || std::abs(back - winner) > tolerance) {
      winners[x] = kNoWinner;
    }
  }
}

}  // namespace stof::dsp::ref
