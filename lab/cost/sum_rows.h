#pragma once

#include <cstdint>
#include <optional>
#include <span>

#include "dsp/base/arena.h"
#include "dsp/stereo/cost/aggregated_ad_census.h"
#include "dsp/stereo/prepared_pair.h"
#include "lab/cost/cost_rows.h"
#include "lab/dsp_names.h"
#include "lab/match_params.h"

namespace stof::lab {

// Rows of the costs of any MatchParams, without those of positions that are not interesting where
// there is an Interest. Sum is u16 or u32, as wide as the search's energies (search/energy.h).
template <typename Sum>
class SumRows {
 public:
  SumRows(const MatchParams& params, int width, Arena& arena) noexcept;

  void start(const PreparedPair& pair) noexcept;
  // Layout of dsp/stereo/cost/sad.h. Valid until the next call.
  std::span<const Sum> row(int y) noexcept;

 private:
  void keep_interesting_pairs(int y, std::span<Sum> costs) noexcept;

  MatchParams params_;
  std::optional<CostRows> blocks_;  // or
  std::optional<AggregatedAdCensus> ad_census_;
  std::span<std::uint8_t> narrow_;  // a row of ad_census_
  std::span<Sum> costs_;            // rows that cannot be handed out as they come
  std::span<std::uint8_t> interesting_left_;
  std::span<std::uint8_t> interesting_right_;
  const PreparedPair* pair_ = nullptr;
};

extern template class SumRows<std::uint16_t>;
extern template class SumRows<std::uint32_t>;

}  // namespace stof::lab
