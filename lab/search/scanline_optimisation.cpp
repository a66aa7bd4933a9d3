#include "lab/search/scanline_optimisation.h"

#include <algorithm>
#include <cstddef>

#include "dsp/base/check.h"
#include "dsp/base/target.h"
#include "dsp/stereo/search/path_costs.h"
#include "dsp/stereo/search/winner.h"

namespace stof::lab {
namespace {

// True where two offered candidates cost different sums.
template <typename Sum>
bool prefers(std::span<const Sum> pixel) noexcept {
  Sum lowest = kNoCost<Sum>;
  Sum highest = 0;
  for (const Sum cost : pixel) {
    lowest = std::min(lowest, cost);
    highest = std::max(highest, cost == kNoCost<Sum> ? Sum{0} : cost);
  }
  return lowest < highest;
}

// The smallest candidate of lowest cost, kNoWinner where none is offered.
template <typename Sum>
int cheapest(std::span<const Sum> pixel, Sum lowest) noexcept {
  if (lowest == kNoCost<Sum>) {
    return kNoWinner;
  }
  return static_cast<int>(std::ranges::find(pixel, lowest) - pixel.begin());
}

// The candidate before one that has `after`: the argument of the minimum in path_costs.h.
template <typename Sum>
int predecessor(std::span<const Sum> before, int after, Sum small, Sum large) noexcept {
  Sum lowest = kNoCost<Sum>;
  for (const Sum path : before) {
    lowest = std::min(lowest, path);
  }
  if (after == kNoWinner || lowest == kNoCost<Sum>) {
    return cheapest(before, lowest);
  }
  int best = kNoWinner;
  std::uint64_t least = std::uint64_t{lowest} + large;
  const int last = static_cast<int>(before.size()) - 1;
  for (int i = std::max(after - 1, 0); i <= std::min(after + 1, last); ++i) {
    const Sum path = before[static_cast<std::size_t>(i)];
    const std::uint64_t sum = std::uint64_t{path} + (i == after ? Sum{0} : small);
    if (path != kNoCost<Sum> && (sum < least || (sum == least && best == kNoWinner))) {
      least = sum;
      best = i;
    }
  }
  if (least == std::uint64_t{lowest} + large) {  // a jump is as good: is it to a smaller candidate?
    const int jump = cheapest(before, lowest);
    best = best == kNoWinner ? jump : std::min(best, jump);
  }
  return best;
}

}  // namespace

template <typename Sum>
void keep_band(std::span<const std::int16_t> winners, int lanes, int band,
               std::span<Sum> costs) noexcept {
  const std::size_t count = static_cast<std::size_t>(lanes);
  const int n = static_cast<int>(winners.size());
  STOF_CHECK(band >= 0 && costs.size() == winners.size() * count);
  for (int x = 0; x < n; ++x) {
    int lowest = lanes;
    int highest = -1;
    const int end = std::min(x + kBandReach + 1, n);
    for (int near = std::max(x - kBandReach, 0); near < end; ++near) {
      const int winner = winners[static_cast<std::size_t>(near)];
      lowest = winner == kNoWinner ? lowest : std::min(lowest, winner);
      highest = std::max(highest, winner);
    }
    const std::size_t begin = static_cast<std::size_t>(std::clamp(lowest - band, 0, lanes));
    const std::size_t stop = static_cast<std::size_t>(std::min(highest + band + 1, lanes));
    const std::span<Sum> pixel = costs.subspan(static_cast<std::size_t>(x) * count, count);
    if (begin >= stop || std::ranges::all_of(pixel.subspan(begin, stop - begin),
                                             [](Sum cost) { return cost == kNoCost<Sum>; })) {
      continue;
    }
    std::ranges::fill(pixel.first(begin), kNoCost<Sum>);
    std::ranges::fill(pixel.subspan(stop), kNoCost<Sum>);
  }
}

template <typename Sum>
bool any_preference(std::span<const Sum> costs, int lanes) noexcept {
  const std::size_t count = static_cast<std::size_t>(lanes);
  for (std::size_t at = 0; at < costs.size(); at += count) {
    if (prefers(costs.subspan(at, count))) {
      return true;
    }
  }
  return false;
}

template <typename Sum>
void scanline_winners(std::span<const Sum> costs, int lanes, Sum small, std::span<const Sum> large,
                      std::span<Sum> paths, std::span<std::int16_t> winners) noexcept {
  const std::size_t count = static_cast<std::size_t>(lanes);
  const std::size_t n = winners.size();
  STOF_CHECK(costs.size() == n * count && paths.size() == costs.size() && large.size() == n + 1);
  best::paths_along(costs, lanes, small, large.first(n), true, paths);
  if (!any_preference(costs, lanes)) {
    std::ranges::fill(winners, kNoWinner);
    return;
  }
  int winner = kNoWinner;
  for (std::size_t x = n; x-- > 0;) {
    winner = predecessor(std::span<const Sum>(paths).subspan(x * count, count), winner, small,
                         large[x + 1]);
    winners[x] = static_cast<std::int16_t>(winner);
  }
}

template <typename Sum>
void scanline_marginals(std::span<const Sum> costs, int lanes, Sum small,
                        std::span<const Sum> large, std::span<const Sum> paths,
                        std::span<Sum> marginals) noexcept {
  STOF_CHECK(costs.size() == (large.size() - 1) * static_cast<std::size_t>(lanes) &&
             paths.size() == costs.size() && marginals.size() == costs.size());
  best::paths_along(costs, lanes, small, large.subspan(1), false, marginals);
  for (std::size_t k = 0; k < costs.size(); ++k) {
    const Sum onward = static_cast<Sum>(marginals[k] - costs[k]);  // the pixel itself counts once
    const Sum sum = static_cast<Sum>(paths[k] + onward);
    marginals[k] = sum < onward ? kNoCost<Sum> : sum;
  }
}

template void keep_band(std::span<const std::int16_t>, int, int, std::span<std::uint16_t>) noexcept;
template void keep_band(std::span<const std::int16_t>, int, int, std::span<std::uint32_t>) noexcept;
template bool any_preference(std::span<const std::uint16_t>, int) noexcept;
template bool any_preference(std::span<const std::uint32_t>, int) noexcept;
template void scanline_winners(std::span<const std::uint16_t>, int, std::uint16_t,
                               std::span<const std::uint16_t>, std::span<std::uint16_t>,
                               std::span<std::int16_t>) noexcept;
template void scanline_winners(std::span<const std::uint32_t>, int, std::uint32_t,
                               std::span<const std::uint32_t>, std::span<std::uint32_t>,
                               std::span<std::int16_t>) noexcept;
template void scanline_marginals(std::span<const std::uint16_t>, int, std::uint16_t,
                                 std::span<const std::uint16_t>, std::span<const std::uint16_t>,
                                 std::span<std::uint16_t>) noexcept;
template void scanline_marginals(std::span<const std::uint32_t>, int, std::uint32_t,
                                 std::span<const std::uint32_t>, std::span<const std::uint32_t>,
                                 std::span<std::uint32_t>) noexcept;

}  // namespace stof::lab
