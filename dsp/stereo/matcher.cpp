#include "dsp/stereo/matcher.h"

#include <algorithm>
#include <type_traits>

#include "dsp/base/check.h"
#include "dsp/base/target.h"
#include "dsp/stereo/check/distinct.h"
#include "dsp/stereo/check/histogram.h"
#include "dsp/stereo/check/left_right.h"
#include "dsp/stereo/check/peak_ratio.h"
#include "dsp/stereo/check/speckle.h"
#include "dsp/stereo/check/texture.h"
#include "dsp/stereo/check/uniqueness.h"
#include "dsp/stereo/cost/cost_layout.h"
#include "dsp/stereo/map_search.h"
#include "dsp/stereo/refine/fill.h"
#include "dsp/stereo/refine/least_squares.h"
#include "dsp/stereo/refine/median.h"
#include "dsp/stereo/refine/subpixel.h"
#include "dsp/stereo/search/energy.h"
#include "dsp/stereo/search/winner.h"

namespace stof::dsp {
namespace {

std::size_t size(int value) noexcept { return static_cast<std::size_t>(value); }

// Rows that a thread searches at once. Semi-global optimisation works on whole stripes; sums over
// blocks begin anew only where a thread takes over what is another's.
int rows_at_once(const MatchParams& params) noexcept {
  return params.method == Method::kSemiGlobal ? SemiGlobal<std::uint8_t, std::uint8_t>::kStripe
                                              : kRowsAtOnce;
}

}  // namespace

void Matcher::match(ImageView<const std::uint8_t> left, ImageView<const std::uint8_t> right,
                    ImageView<Disparity> out, Guide guide) noexcept {
  STOF_CHECK(same_size(left, out));
  start(left, right, guide);
  search(out);
  finish(out);
}

void Matcher::start(ImageView<const std::uint8_t> left, ImageView<const std::uint8_t> right,
                    Guide guide) noexcept {
  STOF_CHECK(guide.empty() || params_.guided);
  width_ = left.width();
  height_ = left.height();
  pair_.start(left, right);
  if (left.empty()) {
    return;
  }
  for (RowSearch<std::uint16_t>& search : searches_) {
    search.start(pair_, guide);
  }
  for (RowSearch<std::uint32_t>& search : wide_searches_) {
    search.start(pair_, guide);
  }
}

void Matcher::search(ImageView<Disparity> out) noexcept {
  if (pair_.filters()) {
    by_rows([this](Rows rows, int) noexcept { filter(rows); });
  }
  if (pair_.derives()) {
    by_rows([this](Rows rows, int) noexcept { derive(rows); });
  }
  if (!searches_map(params_)) {
    crew_.run_rows(out.rows(), rows_at_once(params_),
                   [&](Rows rows, int thread) noexcept { match_rows(rows, out, thread); });
  }
}

void Matcher::filter(Rows rows) noexcept { pair_.filter(rows); }
void Matcher::derive(Rows rows) noexcept { pair_.derive(rows); }

void Matcher::match_rows(Rows rows, ImageView<Disparity> out, int thread) noexcept {
  STOF_CHECK(out.width() == width_ && out.height() == height_ && rows.begin >= 0 &&
             rows.end <= height_);
  if (out.empty() || searches_map(params_)) {
    return;  // in finish()
  }
  if (!searches_.empty()) {
    match_rows_with(searches_[size(thread)], rows, thread, out);
  } else {
    match_rows_with(wide_searches_[size(thread)], rows, thread, out);
  }
}

std::span<std::byte> Matcher::scratch_of(int thread) const noexcept {
  return scratch_.subspan(size(thread) * thread_bytes_, thread_bytes_);
}

ImageView<const std::uint8_t> Matcher::filled() const noexcept {
  return cut(filled_, width_, height_);
}

ImageView<const std::uint8_t> Matcher::ratio() const noexcept {
  return cut(ratio_, width_, height_);
}

ImageView<const Disparity> Matcher::weak() const noexcept { return cut(weak_, width_, height_); }

template <typename Sum>
void Matcher::match_rows_with(RowSearch<Sum>& search, Rows rows, int thread,
                              ImageView<Disparity> out) noexcept {
  for (int y = rows.begin; y < rows.end; ++y) {
    const FoundRow<Sum> found = search.row(y);
    check_row(found, y, thread);
    refine_row(found, y, out.row(y));
  }
}

// Drops winners that their own row speaks against.
template <typename Sum>
void Matcher::check_row(const FoundRow<Sum>& found, int y, int thread) noexcept {
  const int lanes = lanes_of(params_);
  if (!filled_.empty()) {
    std::ranges::copy(found.continued, filled_.row(y).begin());
  }
  if (params_.distinct) {
    judge_distinctness(found, y);
  }
  if (params_.confidence) {
    const std::span<std::uint8_t> ratio = ratio_.row(y).first(found.winners.size());
    if (found.narrow_judged.empty()) {
      best::peak_ratio(found.judged, lanes, found.winners, ratio);
    } else {
      best::peak_ratio(found.narrow_judged, lanes, found.winners, ratio);
    }
  }
  if (params_.uniqueness_percent) {
    best::uniqueness_check(found.judged, lanes, *params_.uniqueness_percent, found.winners);
  }
  if (!params_.left_right_tolerance) {
    return;
  }
  if (params_.method == Method::kOrdered) {
    // Matches of this method are one to one; what it continued has no match to be checked.
    for (std::size_t x = 0; x < found.winners.size(); ++x) {
      found.winners[x] = found.continued[x] != 0 ? kNoWinner : found.winners[x];
    }
    std::ranges::fill(filled_.row(y), std::uint8_t{0});
    return;
  }
  Arena arena(scratch_of(thread));
  const std::size_t right = found.winners.size() + size(lanes) - 1;
  const std::span<std::int16_t> right_winners = arena.take<std::int16_t>(right);
  if (found.narrow_judged.empty()) {
    best::right_winners(found.judged, lanes, arena.take<Sum>(right), right_winners);
  } else {
    best::right_winners(found.narrow_judged, lanes, arena.take<std::uint8_t>(right), right_winners);
  }
  best::left_right_check(right_winners, *params_.left_right_tolerance, found.winners);
}

template <typename Sum>
void Matcher::judge_distinctness(const FoundRow<Sum>& found, int y) noexcept {
  const int lanes = lanes_of(params_);
  const bool regions = params_.cost == Cost::kMixed;
  const int percent = regions ? kDistinctRegionPercent : kDistinctPercent;
  const int shift = margin_shift(largest_cost(params_), lanes);
  const std::span<const std::int16_t> winners = found.winners;
  const std::span<std::int16_t> margins = margins_.row(y).first(winners.size());
  if (found.costs.empty()) {
    best::distinct_margins(found.mixed_costs, lanes, winners, percent, shift, margins);
  } else {
    best::distinct_margins(found.costs, lanes, winners, percent, shift, margins);
  }
}

template <typename Sum>
void Matcher::refine_row(const FoundRow<Sum>& found, int y, std::span<Disparity> out) noexcept {
  const int lanes = lanes_of(params_);
  const int first = params_.min_disparity;
  if (!found.fitted.empty()) {
    for (std::size_t x = 0; x < out.size(); ++x) {  // a check may have dropped a winner since
      out[x].raw = found.winners[x] == kNoWinner ? Disparity::none().raw : found.fitted[x].raw;
    }
    fit_grey_values(y, out);
    return;
  }
  switch (params_.subpixel) {
    case Subpixel::kEquiangular:
      best::refine_winners(found.judged, lanes, first, found.winners, out);
      break;
    case Subpixel::kParabola:
      best::refine_winners_parabola(found.judged, lanes, first, found.winners, out);
      break;
    case Subpixel::kLeastSquares:
    case Subpixel::kWhole:
      best::whole_winners(first, found.winners, out);
  }
  fit_grey_values(y, out);
}

void Matcher::fit_grey_values(int y, std::span<Disparity> out) noexcept {
  if (params_.subpixel == Subpixel::kLeastSquares) {
    best::refine_least_squares(pair_.left_grey(), pair_.right_grey(), y, params_.block_width,
                               params_.block_height, out);
  }
}

void Matcher::match_map(ImageView<Disparity> out) noexcept {
  Arena arena(scratch_);
  const auto winners = arena.take_image<std::int16_t>(width_, height_);
  search_map(params_, pair_, arena, winners);
  by_rows([&](Rows rows, int) noexcept {
    for (int y = rows.begin; y < rows.end; ++y) {
      best::whole_winners(params_.min_disparity, winners.row(y), out.row(y));
      fit_grey_values(y, out.row(y));
      if (!filled_.empty()) {
        std::ranges::fill(filled_.row(y), std::uint8_t{0});
      }
      if (params_.confidence) {
        std::ranges::fill(ratio_.row(y).first(size(width_)), kRatioUnknown);
      }
    }
  });
}

}  // namespace stof::dsp
