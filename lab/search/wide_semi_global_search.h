#pragma once

#include <cstdint>
#include <span>

#include "dsp/base/arena.h"
#include "dsp/stereo/cost/aggregated_ad_census.h"
#include "dsp/stereo/row_checks.h"
#include "dsp/stereo/row_search.h"
#include "dsp/stereo/search/semi_global.h"
#include "lab/cost/cost_rows.h"
#include "lab/cost/scaled_costs.h"
#include "lab/dsp_names.h"
#include "lab/match_params.h"

namespace stof::lab {

// The costs that paths go through: the appliance's, or those of blocks on a scale of their own.
class AdCensusSource {
 public:
  using Cost = std::uint8_t;

  AdCensusSource(const MatchParams& params, int width, Arena& arena) noexcept
      : costs_(params, width, arena) {}
  static PathParams<Cost> path_params(const MatchParams& params) noexcept;
  CostSource<Cost>& start(const PreparedPair& pair) noexcept;

 private:
  AggregatedAdCensus costs_;
};

class BlockSource {
 public:
  using Cost = std::uint16_t;

  BlockSource(const MatchParams& params, int width, Arena& arena) noexcept
      : params_(params), blocks_(params, width, arena) {}
  static PathParams<Cost> path_params(const MatchParams& params) noexcept;
  CostSource<Cost>& start(const PreparedPair& pair) noexcept;

 private:
  MatchParams params_;
  CostRows blocks_;
  ScaledCosts scaled_;
};

// Method::kSemiGlobal with sums of u16, which any directions and penalties fit. Source is one of
// the above.
template <typename Source>
class WideSemiGlobalSearch final : public RowSearch {
 public:
  using Paths = SemiGlobal<typename Source::Cost, std::uint16_t>;

  WideSemiGlobalSearch(const MatchParams& params, int width, Arena& arena) noexcept;

  void start(const PreparedPair& pair, Guide guide) noexcept override;
  void match(int y, const MatchedRow& out) noexcept override;

 private:
  MatchParams params_;
  Source source_;
  Paths paths_;
  RowChecks<std::uint16_t> checks_;
  std::span<std::int16_t> winners_;
  const PreparedPair* pair_ = nullptr;
  Guide guide_;
};

extern template class WideSemiGlobalSearch<AdCensusSource>;
extern template class WideSemiGlobalSearch<BlockSource>;

}  // namespace stof::lab
