#include "dsp/stereo/refine/subpixel.h"

#include <algorithm>
#include <cstddef>
#include <cstdlib>

#include "dsp/base/check.h"

namespace stof::dsp::ref {
namespace {

// costs: the pixel's candidates; 0 < winner < lanes - 1.
template <typename Sum>
int offset(std::span<const Sum> costs, std::size_t winner, CostFit fit) noexcept {
  const Sum before = costs[winner - 1];
  const Sum after = costs[winner + 1];
  const Sum best = costs[winner];
  if (before == kNoCost<Sum> || after == kNoCost<Sum> || before < best || after < best) {
    return 0;
  }
  const std::int64_t rise = fit == CostFit::kEquiangular
                                ? std::int64_t{std::max(before, after)} - best
                                : std::int64_t{before} + after - 2 * std::int64_t{best};
  if (rise == 0) {
    return 0;
  }
  const std::int64_t difference = std::int64_t{before} - after;
  const std::int64_t sixteenths = (16 * std::abs(difference) + rise) / (2 * rise);
  return static_cast<int>(difference < 0 ? -sixteenths : sixteenths);
}

}  // namespace

template <typename Sum>
void refine_winners(std::span<const Sum> costs, int lanes, CostFit fit, int min_disparity,
                    std::span<const std::int16_t> winners, std::span<Disparity> out) noexcept {
  const std::size_t count = static_cast<std::size_t>(lanes);
  STOF_CHECK((fit == CostFit::kNone || costs.size() == winners.size() * count) &&
             out.size() == winners.size());
  for (std::size_t x = 0; x < winners.size(); ++x) {
    const std::int16_t winner = winners[x];
    out[x] =
        winner == kNoWinner ? Disparity::none() : Disparity::from_pixels(min_disparity + winner);
    if (fit != CostFit::kNone && winner > 0 && winner + 1 < lanes) {
      const int shift =
          offset(costs.subspan(x * count, count), static_cast<std::size_t>(winner), fit);
      out[x] = Disparity::from_raw(static_cast<std::int16_t>(out[x].raw + shift));
    }
  }
}

STOF_INSTANTIATE(RefineWinners, refine_winners, std::uint16_t, std::uint32_t);

}  // namespace stof::dsp::ref
