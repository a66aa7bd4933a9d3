#include "dsp/stereo/search/block_search.h"

#include "dsp/base/check.h"
#include "dsp/base/index.h"
#include "dsp/base/target.h"
#include "dsp/stereo/cost/cost_layout.h"
#include "dsp/stereo/search/border_columns.h"

namespace stof::dsp {
namespace {

// The winners and their fit come without the costs.
bool looks_at_costs(const MatchParams& params) noexcept {
  return params.distinct || params.confidence || params.uniqueness_percent ||
         params.left_right_tolerance || params.guided;
}

CostScale scale_of(const MatchParams& params) noexcept {
  STOF_CHECK(params.prefilter_cap.has_value());
  return {.largest =
              std::int64_t{params.block_width} * params.block_height * 2 * *params.prefilter_cap};
}

}  // namespace

BlockSearch::BlockSearch(const MatchParams& params, int width, Arena& arena) noexcept
    : params_(params),
      blocks_(params, width, arena),
      checks_(params, scale_of(params), width, arena),
      winners_(arena.take<std::int16_t>(index(width))) {
  const std::size_t row = index(width) * index(lanes_of(params));
  if (looks_at_costs(params)) {
    costs_ = arena.take<std::uint16_t>(row + 2 * kBlockCostMargin).subspan(kBlockCostMargin, row);
  }
  if (params.guided) {
    masked_ = arena.take<std::uint16_t>(row);
  }
}

void BlockSearch::start(const PreparedPair& pair, Guide guide) noexcept {
  pair_ = &pair;
  guide_ = guide;
  blocks_.start({.left = pair.left(), .right = pair.right()});
}

void BlockSearch::match(int y, const MatchedRow& out) noexcept {
  const int lanes = lanes_of(params_);
  const std::size_t n = out.disparity.size();
  const std::span<std::uint16_t> costs = costs_.empty() ? costs_ : costs_.first(n * index(lanes));
  const std::span<std::int16_t> winners = winners_.first(n);
  blocks_.row(y, {.winners = winners, .fitted = out.disparity, .costs = costs});
  FoundRow<std::uint16_t> found{.costs = costs, .judged = costs, .winners = winners};
  const GuideRow guide = row_of(guide_, y);
  const bool narrowed = narrows(guide, lanes);
  if (narrowed) {
    best::mask_candidates(found.costs, guide, lanes, masked_.first(costs.size()));
    found.judged = masked_.first(costs.size());
    best::winners(found.judged, lanes, winners);
  }
  finish_winners(params_, guide, winners);
  checks_.compare_rivals(found, out);
  if (!narrowed) {  // a guide may leave one candidate, which has no rival
    checks_.drop_ties(out.ratio, winners);
  }
  checks_.check_left_right(found.judged, winners);
  if (narrowed) {
    checks_.fit_costs(found.judged, winners, out.disparity);
  } else {
    drop_fits(winners, out.disparity);
  }
  checks_.fit_grey_values(*pair_, y, out.disparity);
}

// The fits that came with the winners, but for those that were dropped or finished since.
void BlockSearch::drop_fits(std::span<const std::int16_t> winners,
                            std::span<Disparity> out) const noexcept {
  // What had one candidate has no neighbours to be fitted to.
  const int width = static_cast<int>(winners.size());
  for (const int x :
       {params_.min_disparity, width + params_.min_disparity + params_.disparities - 2}) {
    if (x >= 0 && x < width && winners[index(x)] != kNoWinner) {
      out[index(x)] = Disparity::from_pixels(params_.min_disparity + winners[index(x)]);
    }
  }
  for (std::size_t x = 0; x < out.size(); ++x) {
    out[x].raw = winners[x] == kNoWinner ? Disparity::none().raw : out[x].raw;
  }
}

}  // namespace stof::dsp
