#pragma once

#include <cstdint>
#include <span>

#include "dsp/base/arena.h"
#include "dsp/stereo/cost/aggregated_ad_census.h"
#include "dsp/stereo/row_checks.h"
#include "dsp/stereo/row_search.h"
#include "dsp/stereo/search/semi_global.h"

namespace stof::dsp {

// The scale of AggregatedAdCensus for distinctness, and the parameters of paths over it. Small
// changes of grey values are edges already: the costs are averaged over pixels that look alike.
inline constexpr CostScale kAdCensusScale{.largest = kLargestMeanCost,
                                          .margin_percent = kAdCensusMarginPercent};
PathParams<std::uint8_t> ad_census_path_params(const MatchParams& params, int directions) noexcept;

// Search::kSemiGlobal.
class SemiGlobalSearch final : public RowSearch {
 public:
  static constexpr int kDirections = 4;
  using Paths = SemiGlobal<std::uint8_t, std::uint8_t>;

  SemiGlobalSearch(const MatchParams& params, int width, Arena& arena) noexcept;

  void start(const PreparedPair& pair, Guide guide) noexcept override;
  void match(int y, const MatchedRow& out) noexcept override;

 private:
  MatchParams params_;
  AggregatedAdCensus costs_;
  Paths paths_;
  RowChecks<std::uint8_t> checks_;
  std::span<std::int16_t> winners_;
  const PreparedPair* pair_ = nullptr;
  Guide guide_;
};

}  // namespace stof::dsp
