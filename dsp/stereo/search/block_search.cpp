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
      numbered_(!params.guided && !params.uniqueness_percent),
      blocks_(params, width, arena),
      checks_(params, scale_of(params), width, arena),
      winners_(arena.take_passing<std::int16_t>(index(width))) {
  const std::size_t row = index(width) * index(lanes_of(params));
  if (looks_at_costs(params)) {
    costs_ = arena.take_passing<std::uint16_t>(row + 2 * kBlockCostMargin)
                 .subspan(kBlockCostMargin, row);
  }
  if (params.guided) {
    masked_ = arena.take_passing<std::uint16_t>(row);
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
  const GuideRow guide = row_of(guide_, y);
  const bool narrowed = narrows(guide, lanes);
  MatchedRow rest = out;  // what the pass does not find
  if (!narrowed) {
    rest.margins = {};
  }
  blocks_.row(y, checks_.margin(),
              {.winners = winners,
               .fitted = out.disparity,
               .costs = costs,
               .margins = narrowed ? std::span<std::int16_t>() : out.margins,
               .numbered = numbered_});
  FoundRow<std::uint16_t> found{
      .costs = costs, .judged = costs, .winners = winners, .numbered = numbered_};
  if (narrowed) {
    best::mask_candidates(found.costs, guide, lanes, masked_.first(costs.size()));
    found.judged = masked_.first(costs.size());
    best::winners(found.judged, lanes, winners);
  }
  finish_winners(params_, guide, winners);
  checks_.compare_rivals(found, rest);
  if (!narrowed) {
    compare_border(found, out);
    // A guide may leave one candidate, which has no rival.
    checks_.drop_ties(out.ratio, winners);
  }
  checks_.check_left_right(found.judged, winners, found.numbered);
  if (narrowed) {
    checks_.fit_costs(found.judged, winners, out.disparity);
  } else {
    drop_fits(winners, out.disparity);
  }
  checks_.fit_grey_values(*pair_, y, out.disparity);
}

// The columns at either end of the range, which have one candidate each.
std::array<int, 2> BlockSearch::border_columns(int width) const noexcept {
  return {params_.min_disparity, width + params_.min_disparity + params_.disparities - 2};
}

// Margins of border columns, whose winners came after the pass.
void BlockSearch::compare_border(const FoundRow<std::uint16_t>& found,
                                 const MatchedRow& out) noexcept {
  const std::size_t lanes = index(lanes_of(params_));
  const int width = static_cast<int>(found.winners.size());
  for (const int x : border_columns(width)) {
    if (!out.margins.empty() && x >= 0 && x < width) {
      std::array<std::uint16_t, 256> costs;
      for (std::size_t i = 0; i < lanes; ++i) {
        const std::uint16_t cost = found.costs[index(x) * lanes + i];
        costs[i] = numbered_ ? cost_of_numbered(cost) : cost;
      }
      checks_.compare_costs(std::span<const std::uint16_t>(costs).first(lanes),
                            found.winners.subspan(index(x), 1), out.margins.subspan(index(x), 1));
    }
  }
}

// The fits that came with the winners, but for those that were dropped or finished since.
void BlockSearch::drop_fits(std::span<const std::int16_t> winners,
                            std::span<Disparity> out) const noexcept {
  // What had one candidate has no neighbours to be fitted to.
  const int width = static_cast<int>(winners.size());
  for (const int x : border_columns(width)) {
    if (x >= 0 && x < width && winners[index(x)] != kNoWinner) {
      out[index(x)] = Disparity::from_pixels(params_.min_disparity + winners[index(x)]);
    }
  }
  const std::int16_t* const winner = winners.data();
  const std::size_t n = out.size();
  for (std::size_t x = 0; x < n; ++x) {  // without a branch, so that compilers make vectors of it
    const Disparity fit = out[x];
    out[x] = winner[x] == kNoWinner ? Disparity::none() : fit;
  }
}

}  // namespace stof::dsp
