#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>

#include "dsp/base/arena.h"
#include "dsp/stereo/cost/cost_rows.h"
#include "dsp/stereo/cost/cross_costs.h"
#include "dsp/stereo/cost/mask_costs.h"
#include "dsp/stereo/match_params.h"
#include "dsp/stereo/prepared_pair.h"
#include "dsp/stereo/search/block_search.h"
#include "dsp/stereo/search/scaled_costs.h"
#include "dsp/stereo/search/semi_global.h"

namespace stof::dsp {

// What was found in one row; layouts of cost/sad.h and search/winner.h.
template <typename Sum>
struct FoundRow {
  // Of blocks, for all candidates, whatever a guide says; empty where mixed_costs has them.
  std::span<const Sum> costs{};
  std::span<const std::uint8_t> mixed_costs{};
  // What the winners are the lowest of: block costs, or sums over paths, of the candidates that a
  // guide leaves. Checks and fits look here,
  // or in narrow_judged, which holds the same numbers where they fit. judged is empty then, unless
  // a fit of costs or the uniqueness needs it.
  std::span<const Sum> judged{};
  std::span<const std::uint8_t> narrow_judged{};
  std::span<std::int16_t> winners;
  // The winners with the fit of their costs, where that came with the search; else empty.
  std::span<const Disparity> fitted{};
  // 1 where a winner is none of the search's own but was continued from the background.
  std::span<const std::uint8_t> continued;
};

// Cost and method of a MatchParams, row by row. Sums are u16 or u32: needs_wide_sums()
// (search/energy.h).
template <typename Sum>
class RowSearch {
 public:
  static std::size_t bytes_needed(const MatchParams& params, int width) noexcept;
  RowSearch(const MatchParams& params, int width, Arena& arena) noexcept;

  // New pictures, which must stay as they are until the last row. guide: of their size, or empty;
  // only where params are `guided`.
  void start(const PreparedPair& pair, Guide guide) noexcept;
  // Valid until the next call. In order rows are cheapest; any order gives the same.
  FoundRow<Sum> row(int y) noexcept;

 private:
  FoundRow<Sum> search(int y) noexcept;
  void search_blocks(int y, FoundRow<std::uint16_t>& found) noexcept;
  void settle_fits(std::span<const std::int16_t> winners) noexcept;
  std::span<const Sum> block_costs(int y) noexcept;
  std::span<const Sum> guided_costs(int y, std::span<const Sum> costs) noexcept;
  void semi_global(int y, FoundRow<std::uint16_t>& found) noexcept;
  void narrow_semi_global(int y, FoundRow<std::uint16_t>& found) noexcept;
  void scanline(int y, FoundRow<Sum>& found) noexcept;
  void ordered(int y, FoundRow<Sum>& found) noexcept;
  void keep_interesting_pairs(int y, std::span<Sum> costs) noexcept;

  MatchParams params_;
  int lanes_;
  EdgePenalties<Sum> penalties_;  // scanline and ordered
  Sum occlusion_ = 0;
  const PreparedPair* pair_ = nullptr;
  Guide guide_;

  std::optional<BlockSearch> block_search_;  // for most block matching; else
  std::optional<CostRows> block_rows_;
  std::optional<CrossCosts> cross_rows_;
  std::optional<SemiGlobal<std::uint8_t, std::uint8_t>> narrow_paths_;
  std::optional<SemiGlobal<std::uint8_t, std::uint16_t>> mixed_paths_;
  std::optional<SemiGlobal<std::uint16_t, std::uint16_t>> block_paths_;
  ScaledCosts scaled_;

  std::span<Sum> costs_;      // with kBlockCostMargin elements before and behind them
  std::span<Sum> masked_;     // guided
  std::span<Sum> paths_;      // scanline
  std::span<Sum> marginals_;  // scanline
  std::span<Sum> large_;      // width + 1
  std::span<std::byte> ordered_scratch_;
  std::span<std::uint8_t> narrow_;  // one row of cross_rows_
  std::span<std::uint8_t> continued_;
  std::span<std::uint8_t> interesting_left_;
  std::span<std::uint8_t> interesting_right_;
  std::span<std::int16_t> winners_;
  std::span<Disparity> fitted_;  // with a block_search_
};

extern template class RowSearch<std::uint16_t>;
extern template class RowSearch<std::uint32_t>;

}  // namespace stof::dsp
