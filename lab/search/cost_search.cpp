#include "lab/search/cost_search.h"

#include <algorithm>

#include "dsp/base/index.h"
#include "dsp/base/target.h"
#include "dsp/stereo/cost/candidate_mask.h"
#include "dsp/stereo/cost/cost_layout.h"
#include "dsp/stereo/search/border_columns.h"
#include "dsp/stereo/search/winner.h"
#include "lab/block/interest.h"
#include "lab/search/energy.h"
#include "lab/search/scanline_optimisation.h"

namespace stof::lab {

template <typename Sum>
CostSearch<Sum>::CostSearch(const MatchParams& params, int width, Arena& arena) noexcept
    : params_(params),
      lanes_(lanes_of(params)),
      rows_(params, width, arena),
      checks_(params, cost_scale(params), width, arena),
      masked_(arena.take<Sum>(params.guided ? index(width) * index(lanes_) : 0)),
      winners_(arena.take<std::int16_t>(index(width))) {}

template <typename Sum>
void CostSearch<Sum>::start(const PreparedPair& pair, Guide guide) noexcept {
  pair_ = &pair;
  guide_ = guide;
  rows_.start(pair);
}

template <typename Sum>
void CostSearch<Sum>::match(int y, const MatchedRow& out) noexcept {
  const GuideRow guide = row_of(guide_, y);
  FoundRow<Sum> found;
  found.costs = rows_.row(y);
  found.judged = found.costs;
  found.winners = winners_.first(out.disparity.size());
  if (narrows(guide, lanes_)) {
    best::mask_candidates(found.costs, guide, lanes_, masked_.first(found.costs.size()));
    found.judged = masked_.first(found.costs.size());
  }
  find(y, found);
  finish_winners(params_, guide, found.winners);
  checks_.compare_rivals(found, out);
  check_left_right(y, found);
  checks_.fit_costs(found.judged, found.winners, out.disparity);
  checks_.fit_grey_values(*pair_, y, out.disparity);
}

template <typename Sum>
void CostSearch<Sum>::check_left_right(int, const FoundRow<Sum>& found) noexcept {
  checks_.check_left_right(found.judged, found.winners);
}

template <typename Sum>
std::span<const Sum> CostSearch<Sum>::penalties_along(int y, const EdgePenalties<Sum>& penalties,
                                                      std::span<Sum> large) const noexcept {
  const std::span<const std::uint8_t> row = pair_->left_grey().row(y);
  edge_penalties_along(row, penalties, large.first(row.size() + 1));
  return large.first(row.size() + 1);
}

template <typename Sum>
void WinnerSearch<Sum>::find(int, FoundRow<Sum>& found) noexcept {
  if (this->params().interest) {
    interesting_winners(found.judged, this->lanes(), found.winners);
  } else {
    best::winners(found.judged, this->lanes(), found.winners);
  }
}

template <typename Sum>
ScanlineOptimisationSearch<Sum>::ScanlineOptimisationSearch(const MatchParams& params, int width,
                                                            Arena& arena) noexcept
    : CostSearch<Sum>(params, width, arena), penalties_(block_penalties<Sum>(params)) {
  const std::size_t row = index(width) * index(lanes_of(params));
  large_ = arena.take<Sum>(index(width) + 1);
  banded_ = arena.take<Sum>(params.band ? row : 0);
  paths_ = arena.take<Sum>(row);
  marginals_ = arena.take<Sum>(row);
}

template <typename Sum>
void ScanlineOptimisationSearch<Sum>::find(int y, FoundRow<Sum>& found) noexcept {
  const int lanes = this->lanes();
  const std::size_t n = found.judged.size();
  std::span<const Sum> costs = found.judged;
  if (this->params().band) {
    best::winners(costs, lanes, found.winners);
    std::ranges::copy(costs, banded_.begin());
    keep_band(std::span<const std::int16_t>(found.winners), lanes, *this->params().band,
              banded_.first(n));
    costs = banded_.first(n);
  }
  const std::span<const Sum> large = this->penalties_along(y, penalties_, large_);
  scanline_winners(costs, lanes, penalties_.small, large, paths_.first(n), found.winners);
  scanline_marginals(costs, lanes, penalties_.small, large, std::span<const Sum>(paths_.first(n)),
                     marginals_.first(n));
  found.judged = marginals_.first(n);
}

template <typename Sum>
DynamicProgrammingSearch<Sum>::DynamicProgrammingSearch(const MatchParams& params,
                                                        ImageView<std::uint8_t> continued,
                                                        int width, Arena& arena) noexcept
    : CostSearch<Sum>(params, width, arena),
      penalties_(block_penalties<Sum>(params)),
      occlusion_(block_occlusion<Sum>(params)),
      large_(arena.take<Sum>(index(width) + 1)),
      table_(width, lanes_of(params), arena),
      continued_(continued) {}

template <typename Sum>
void DynamicProgrammingSearch<Sum>::find(int y, FoundRow<Sum>& found) noexcept {
  dp_winners(found.judged, this->lanes(),
             {.small = penalties_.small,
              .occlusion = occlusion_,
              .large = this->penalties_along(y, penalties_, large_)},
             table_, found.winners);
  extend_background(found.winners, continued_.row(y).first(found.winners.size()));
}

// Matches of this method are one to one; what it continued has no match to be checked.
template <typename Sum>
void DynamicProgrammingSearch<Sum>::check_left_right(int y, const FoundRow<Sum>& found) noexcept {
  if (!this->params().left_right_tolerance) {
    return;
  }
  const std::span<std::uint8_t> continued = continued_.row(y).first(found.winners.size());
  for (std::size_t x = 0; x < found.winners.size(); ++x) {
    found.winners[x] = continued[x] != 0 ? kNoWinner : found.winners[x];
  }
  std::ranges::fill(continued, std::uint8_t{0});
}

template class WinnerSearch<std::uint16_t>;
template class WinnerSearch<std::uint32_t>;
template class ScanlineOptimisationSearch<std::uint16_t>;
template class ScanlineOptimisationSearch<std::uint32_t>;
template class DynamicProgrammingSearch<std::uint16_t>;
template class DynamicProgrammingSearch<std::uint32_t>;

}  // namespace stof::lab
