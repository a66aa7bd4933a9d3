#pragma once

#include <cstdint>
#include <span>

#include "dsp/base/arena.h"
#include "dsp/stereo/row_checks.h"
#include "dsp/stereo/row_search.h"
#include "dsp/stereo/search/edge_penalties.h"
#include "lab/cost/sum_rows.h"
#include "lab/dsp_names.h"
#include "lab/match_params.h"
#include "lab/search/dynamic_programming.h"

namespace stof::lab {

// Searches of one row of costs at a time, each with its way to find the winners. Sum is u16 or u32:
// needs_wide_sums() (energy.h).
template <typename Sum>
class CostSearch : public RowSearch {
 public:
  void start(const PreparedPair& pair, Guide guide) noexcept override;
  void match(int y, const MatchedRow& out) noexcept override;

 protected:
  CostSearch(const MatchParams& params, int width, Arena& arena) noexcept;
  ~CostSearch() = default;

  // found: costs, what a guide leaves of them as `judged`, and winners to be written.
  virtual void find(int y, FoundRow<Sum>& found) noexcept = 0;
  virtual void check_left_right(int y, const FoundRow<Sum>& found) noexcept;

  // The penalties for a large change along row y.
  std::span<const Sum> penalties_along(int y, const EdgePenalties<Sum>& penalties,
                                       std::span<Sum> large) const noexcept;
  const MatchParams& params() const noexcept { return params_; }
  int lanes() const noexcept { return lanes_; }

 private:
  MatchParams params_;
  int lanes_;
  SumRows<Sum> rows_;
  RowChecks<Sum> checks_;
  std::span<Sum> masked_;  // guided
  std::span<std::int16_t> winners_;
  const PreparedPair* pair_ = nullptr;
  Guide guide_;
};

// Method::kWinnerTakesAll.
template <typename Sum>
class WinnerSearch final : public CostSearch<Sum> {
 public:
  WinnerSearch(const MatchParams& params, int width, Arena& arena) noexcept
      : CostSearch<Sum>(params, width, arena) {}

 private:
  void find(int y, FoundRow<Sum>& found) noexcept override;
};

template <typename Sum>
class ScanlineOptimisationSearch final : public CostSearch<Sum> {
 public:
  ScanlineOptimisationSearch(const MatchParams& params, int width, Arena& arena) noexcept;

 private:
  void find(int y, FoundRow<Sum>& found) noexcept override;

  EdgePenalties<Sum> penalties_;
  std::span<Sum> large_;  // width + 1
  std::span<Sum> banded_;
  std::span<Sum> paths_;
  std::span<Sum> marginals_;
};

template <typename Sum>
class DynamicProgrammingSearch final : public CostSearch<Sum> {
 public:
  // continued: becomes 1 where a winner is none of the search's own, but was continued from the
  // background; else 0.
  DynamicProgrammingSearch(const MatchParams& params, ImageView<std::uint8_t> continued, int width,
                           Arena& arena) noexcept;

 private:
  void find(int y, FoundRow<Sum>& found) noexcept override;
  void check_left_right(int y, const FoundRow<Sum>& found) noexcept override;

  EdgePenalties<Sum> penalties_;
  Sum occlusion_;
  std::span<Sum> large_;  // width + 1
  DpTable<Sum> table_;
  ImageView<std::uint8_t> continued_;
};

extern template class WinnerSearch<std::uint16_t>;
extern template class WinnerSearch<std::uint32_t>;
extern template class ScanlineOptimisationSearch<std::uint16_t>;
extern template class ScanlineOptimisationSearch<std::uint32_t>;
extern template class DynamicProgrammingSearch<std::uint16_t>;
extern template class DynamicProgrammingSearch<std::uint32_t>;

}  // namespace stof::lab
