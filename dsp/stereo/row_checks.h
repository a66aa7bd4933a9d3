#pragma once

#include <algorithm>
#include <cstdint>
#include <span>
#include <type_traits>

#include "dsp/base/arena.h"
#include "dsp/base/index.h"
#include "dsp/base/target.h"
#include "dsp/stereo/cost/cost_layout.h"
#include "dsp/stereo/found_row.h"
#include "dsp/stereo/match_params.h"
#include "dsp/stereo/prepared_pair.h"
#include "dsp/stereo/refine/least_squares.h"
#include "dsp/stereo/refine/subpixel.h"
#include "dsp/stereo/row_search.h"
#include "dsp/stereo/search/numbered_right_winners.h"
#include "dsp/stereo/search/winner.h"
#include "dsp/stereo/validation/left_right.h"
#include "dsp/stereo/validation/peak_ratio.h"
#include "dsp/stereo/validation/uniqueness.h"
#include "dsp/stereo/validation/winner_margin.h"

namespace stof::dsp {

struct CostScale {           // for distinctness (validation/winner_margin.h)
  std::int64_t largest = 0;  // cost
  int margin_percent = kMarginPercent;
};

// Drops winners of a row that the row itself speaks against, and fits the others. Its steps may be
// called one by one, in the order of apply(). Sum is u8, u16 or u32.
template <typename Sum>
class RowChecks {
 public:
  RowChecks(const MatchParams& params, const CostScale& scale, int width, Arena& arena) noexcept
      : params_(params),
        lanes_(lanes_of(params)),
        margin_{.percent = scale.margin_percent, .shift = margin_shift(scale.largest, lanes_)} {
    if (params.left_right_tolerance) {
      const std::size_t right = index(width + lanes_ - 1);
      lowest_ = arena.take_passing<Sum>(right);
      right_winners_ = arena.take_passing<std::int16_t>(right);
    }
    if (kNarrow && cost_fit(params.subpixel) != CostFit::kNone) {
      widened_ = arena.take_passing<std::uint16_t>(index(width) * index(lanes_));
    }
  }

  template <typename Cost>
  void apply(const FoundRow<Cost, Sum>& found, const PreparedPair& pair, int y,
             const MatchedRow& out) noexcept {
    compare_rivals(found, out);
    check_left_right(found.judged, found.winners, found.numbered);
    fit_costs(found.judged, found.winners, out.disparity);
    fit_grey_values(pair, y, out.disparity);
  }

  MarginScale margin() const noexcept { return margin_; }

  // Margins, where `out` has room, peak ratio, uniqueness; the ratio alone of numbered costs.
  template <typename Cost>
  void compare_rivals(const FoundRow<Cost, Sum>& found, const MatchedRow& out) noexcept {
    if (!out.margins.empty()) {
      compare_costs(found.costs, found.winners, out.margins);
    }
    if (params_.confidence) {
      best::peak_ratio(found.judged, lanes_, found.numbered,
                       std::span<const std::int16_t>(found.winners), out.ratio);
    }
    if (params_.uniqueness_percent) {
      best::uniqueness_check(found.judged, lanes_, *params_.uniqueness_percent, found.winners);
    }
  }

  template <typename Cost>
  void compare_costs(std::span<const Cost> costs, std::span<const std::int16_t> winners,
                     std::span<std::int16_t> margins) const noexcept {
    best::winner_margins(costs, lanes_, winners, margin_.percent, margin_.shift, margins);
  }

  // Where a rival costs no more than the winner (a pattern that repeats), or nothing was compared,
  // the winner is chance. Only where the ratio is known.
  void drop_ties(std::span<const std::uint8_t> ratio,
                 std::span<std::int16_t> winners) const noexcept {
    if (!params_.distinct || !params_.confidence) {
      return;
    }
    const std::uint8_t* const of = ratio.data();
    for (std::size_t x = 0; x < winners.size(); ++x) {
      const std::int16_t winner = winners[x];
      winners[x] = of[x] == kRatioOfTie ? kNoWinner : winner;
    }
  }

  // numbered: whether the costs are numbered_cost() each, which u16 alone can be.
  void check_left_right(std::span<const Sum> judged, std::span<std::int16_t> winners,
                        bool numbered = false) noexcept {
    if (params_.left_right_tolerance) {
      const std::size_t n = winners.size() + index(lanes_) - 1;
      if constexpr (std::is_same_v<Sum, std::uint16_t>) {
        numbered ? best::numbered_right_winners(judged, lanes_, right_winners_.first(n))
                 : best::right_winners(judged, lanes_, lowest_.first(n), right_winners_.first(n));
      } else {
        best::right_winners(judged, lanes_, lowest_.first(n), right_winners_.first(n));
      }
      best::left_right_check(right_winners_.first(n), *params_.left_right_tolerance, winners);
    }
  }

  void fit_costs(std::span<const Sum> judged, std::span<const std::int16_t> winners,
                 std::span<Disparity> out) noexcept {
    const CostFit fit = cost_fit(params_.subpixel);
    best::refine_winners(wide(judged.first(fit == CostFit::kNone ? 0 : judged.size())), lanes_, fit,
                         params_.min_disparity, winners, out);
  }

  void fit_grey_values(const PreparedPair& pair, int y, std::span<Disparity> out) const noexcept {
    if (params_.subpixel == Subpixel::kLeastSquares) {
      best::refine_least_squares(pair.left_grey(), pair.right_grey(), y, params_.block_width,
                                 params_.block_height, out);
    }
  }

 private:
  static constexpr bool kNarrow = std::is_same_v<Sum, std::uint8_t>;

  // Fits need room above the sums.
  auto wide(std::span<const Sum> judged) noexcept {
    if constexpr (kNarrow) {
      const std::span<std::uint16_t> widened = widened_.first(judged.size());
      std::ranges::transform(judged, widened.begin(), [](Sum sum) noexcept {
        return sum == kNoCost<Sum> ? kNoCost<std::uint16_t> : std::uint16_t{sum};
      });
      return std::span<const std::uint16_t>(widened);
    } else {
      return judged;
    }
  }

  MatchParams params_;
  int lanes_;
  MarginScale margin_;
  std::span<Sum> lowest_;
  std::span<std::int16_t> right_winners_;
  std::span<std::uint16_t> widened_;
};

}  // namespace stof::dsp
