#pragma once

#include <array>
#include <cstdint>
#include <span>

#include "dsp/base/arena.h"
#include "dsp/stereo/row_checks.h"
#include "dsp/stereo/row_search.h"
#include "dsp/stereo/search/sliding_blocks.h"

namespace stof::dsp {

// Search::kBlocks.
class BlockSearch final : public RowSearch {
 public:
  BlockSearch(const MatchParams& params, int width, Arena& arena) noexcept;

  void start(const PreparedPair& pair, Guide guide) noexcept override;
  void match(int y, const MatchedRow& out) noexcept override;

 private:
  std::array<int, 2> border_columns(int width) const noexcept;
  void compare_border(const FoundRow<std::uint16_t>& found, const MatchedRow& out) noexcept;
  void drop_fits(std::span<const std::int16_t> winners, std::span<Disparity> out) const noexcept;

  MatchParams params_;
  bool numbered_;  // costs, where no guide and no uniqueness asks for plain ones
  SlidingBlocks blocks_;
  RowChecks<std::uint16_t> checks_;
  std::span<std::uint16_t> costs_;  // with kBlockCostMargin elements before and behind them
  std::span<std::uint16_t> masked_;
  std::span<std::int16_t> winners_;
  const PreparedPair* pair_ = nullptr;
  Guide guide_;
};

}  // namespace stof::dsp
