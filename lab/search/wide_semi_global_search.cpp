#include "lab/search/wide_semi_global_search.h"

#include "dsp/base/index.h"
#include "dsp/base/target.h"
#include "dsp/stereo/cost/candidate_mask.h"
#include "dsp/stereo/cost/cost_layout.h"
#include "dsp/stereo/search/border_columns.h"
#include "dsp/stereo/search/semi_global_body.h"
#include "dsp/stereo/search/semi_global_search.h"
#include "lab/search/energy.h"

namespace stof::dsp {

template class SemiGlobal<std::uint8_t, std::uint16_t>;
template class SemiGlobal<std::uint16_t, std::uint16_t>;

}  // namespace stof::dsp

namespace stof::lab {

PathParams<std::uint8_t> AdCensusSource::path_params(const MatchParams& params) noexcept {
  return ad_census_path_params(params, params.directions);
}

CostSource<std::uint8_t>& AdCensusSource::start(const PreparedPair& pair) noexcept {
  costs_.start(pair.left_grey(), pair.right_grey());
  return costs_;
}

PathParams<std::uint16_t> BlockSource::path_params(const MatchParams& params) noexcept {
  return block_path_params(params);
}

CostSource<std::uint16_t>& BlockSource::start(const PreparedPair& pair) noexcept {
  blocks_.start({.left = pair.left(), .right = pair.right()});
  scaled_.start(blocks_, params_);
  return scaled_;
}

template <typename Source>
WideSemiGlobalSearch<Source>::WideSemiGlobalSearch(const MatchParams& params, int width,
                                                   Arena& arena) noexcept
    : params_(params),
      source_(params, width, arena),
      paths_(Source::path_params(params), width, arena),
      checks_(params, cost_scale(params), width, arena),
      winners_(arena.take<std::int16_t>(index(width))) {}

template <typename Source>
void WideSemiGlobalSearch<Source>::start(const PreparedPair& pair, Guide guide) noexcept {
  pair_ = &pair;
  guide_ = guide;
  paths_.start(pair.left_grey(), source_.start(pair), guide);
}

template <typename Source>
void WideSemiGlobalSearch<Source>::match(int y, const MatchedRow& out) noexcept {
  const int lanes = lanes_of(params_);
  const GuideRow guide = row_of(guide_, y);
  const std::span<std::uint16_t> sums = paths_.sums(y);
  mark_outside(params_, pair_->left().width(), sums);
  if (!guide.empty()) {
    best::mask_candidates(std::span<const std::uint16_t>(sums), guide, lanes, sums);
  }
  const FoundRow<typename Source::Cost, std::uint16_t> found{
      .costs = paths_.costs(y), .judged = sums, .winners = winners_.first(out.disparity.size())};
  best::winners(found.judged, lanes, found.winners);
  finish_winners(params_, guide, found.winners);
  checks_.apply(found, *pair_, y, out);
}

template class WideSemiGlobalSearch<AdCensusSource>;
template class WideSemiGlobalSearch<BlockSource>;

}  // namespace stof::lab
