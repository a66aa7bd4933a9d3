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

bool fills(const MatchParams& params) noexcept {
  return params.fill || params.method == Method::kOrdered;
}

bool keeps_weak(const MatchParams& params) noexcept {
  return params.confidence && (params.distinct || params.min_texture);
}

// The most that one step takes for itself.
std::size_t scratch_bytes(const MatchParams& params, int width, int height) noexcept {
  const std::size_t right = size(width) + size(lanes_of(params)) - 1;
  std::size_t bytes =
      Arena::bytes_for<std::uint32_t>(right) + Arena::bytes_for<std::int16_t>(right);
  const auto needs = [&](std::size_t more) noexcept { bytes = std::max(bytes, more); };
  if (params.distinct) {
    needs(drop_indistinct_bytes(width));
  }
  if (params.min_texture) {
    needs(drop_flat_bytes(width));
  }
  if (params.histogram_permille) {
    needs(Arena::bytes_for<std::uint32_t>(size(params.disparities) + 1));
  }
  if (params.speckle_pixels) {
    needs(drop_speckles_bytes(width, height));
  }
  if (searches_map(params)) {
    needs(Arena::bytes_for<std::int16_t>(size(width) * size(height)) +
          search_map_bytes(params, width, height));
  }
  return bytes;
}

}  // namespace

std::size_t Matcher::bytes_needed(const MatchParams& params, int width, int height) noexcept {
  const std::size_t pixels = size(width) * size(height);
  std::size_t bytes =
      PreparedPair::bytes_needed(params, width, height) +
      (needs_wide_sums(params) ? RowSearch<std::uint32_t>::bytes_needed(params, width)
                               : RowSearch<std::uint16_t>::bytes_needed(params, width));
  bytes += params.distinct ? Arena::bytes_for<std::int16_t>(pixels) : 0;
  bytes += params.median || keeps_weak(params) ? Arena::bytes_for<Disparity>(pixels) : 0;
  bytes += fills(params) ? Arena::bytes_for<std::uint8_t>(pixels) : 0;
  bytes += params.confidence ? Arena::bytes_for<std::uint8_t>(pixels) : 0;
  bytes += keeps_weak(params) && !params.distinct ? Arena::bytes_for<Disparity>(pixels) : 0;
  return bytes + Arena::bytes_for<std::byte>(scratch_bytes(params, width, height));
}

Matcher::Matcher(const MatchParams& params, int width, int height, Arena& arena) noexcept
    : params_(params), pair_(params, width, height, arena) {
  STOF_CHECK(check(params, width, height) == Status::kOk);
  if (needs_wide_sums(params)) {
    wide_search_.emplace(params, width, arena);
  } else {
    search_.emplace(params, width, arena);
  }
  if (params.distinct) {
    margins_ = arena.take_image<std::int16_t>(width, height);
  }
  if (params.median || keeps_weak(params)) {
    spare_ = arena.take_image<Disparity>(width, height);
  }
  if (fills(params)) {
    filled_ = arena.take_image<std::uint8_t>(width, height);
  }
  if (params.confidence) {
    ratio_ = arena.take_image<std::uint8_t>(width, height);
  }
  if (keeps_weak(params)) {
    // Margins are of no use once the indistinct ones are dropped.
    weak_ = params.distinct
                ? ImageView<Disparity>(
                      reinterpret_cast<Disparity*>(margins_.data()),  // NOLINT: both are an i16
                      width, height)
                : arena.take_image<Disparity>(width, height);
  }
  scratch_ = arena.take<std::byte>(scratch_bytes(params, width, height));
}

void Matcher::match(ImageView<const std::uint8_t> left, ImageView<const std::uint8_t> right,
                    ImageView<Disparity> out, Guide guide) noexcept {
  STOF_CHECK(same_size(left, out));
  start(left, right, guide);
  filter(left.rows());
  derive(left.rows());
  match_rows(left.rows(), out);
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
  if (search_) {
    search_->start(pair_, guide);
  } else {
    wide_search_->start(pair_, guide);
  }
}

void Matcher::filter(Rows rows) noexcept { pair_.filter(rows); }
void Matcher::derive(Rows rows) noexcept { pair_.derive(rows); }

void Matcher::match_rows(Rows rows, ImageView<Disparity> out) noexcept {
  STOF_CHECK(out.width() == width_ && out.height() == height_ && rows.begin >= 0 &&
             rows.end <= height_);
  if (out.empty() || searches_map(params_)) {
    return;  // in finish()
  }
  if (search_) {
    match_rows_with(*search_, rows, out);
  } else {
    match_rows_with(*wide_search_, rows, out);
  }
}

ImageView<const std::uint8_t> Matcher::filled() const noexcept {
  return cut(filled_, width_, height_);
}

ImageView<const std::uint8_t> Matcher::ratio() const noexcept {
  return cut(ratio_, width_, height_);
}

ImageView<const Disparity> Matcher::weak() const noexcept { return cut(weak_, width_, height_); }

template <typename Sum>
void Matcher::match_rows_with(RowSearch<Sum>& search, Rows rows,
                              ImageView<Disparity> out) noexcept {
  for (int y = rows.begin; y < rows.end; ++y) {
    const FoundRow<Sum> found = search.row(y);
    check_row(found, y);
    refine_row(found, y, out.row(y));
  }
}

// Drops winners that their own row speaks against.
template <typename Sum>
void Matcher::check_row(const FoundRow<Sum>& found, int y) noexcept {
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
  Arena arena(scratch_);
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
  for (int y = 0; y < height_; ++y) {
    best::whole_winners(params_.min_disparity, winners.row(y), out.row(y));
    fit_grey_values(y, out.row(y));
    if (!filled_.empty()) {
      std::ranges::fill(filled_.row(y), std::uint8_t{0});
    }
    if (params_.confidence) {
      std::ranges::fill(ratio_.row(y).first(size(width_)), kRatioUnknown);
    }
  }
}

}  // namespace stof::dsp
