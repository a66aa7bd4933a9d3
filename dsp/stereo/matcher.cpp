#include "dsp/stereo/matcher.h"

#include <algorithm>
#include <cstdlib>

#include "dsp/base/check.h"
#include "dsp/base/target.h"
#include "dsp/stereo/check/left_right.h"
#include "dsp/stereo/cost/prefilter.h"
#include "dsp/stereo/cost/sad.h"
#include "dsp/stereo/refine/subpixel.h"
#include "dsp/stereo/search/winner.h"

namespace stof::dsp {
namespace {

std::size_t size(int value) noexcept { return static_cast<std::size_t>(value); }

int lanes_of(const MatchParams& params) noexcept {
  return (params.disparities + kCostLanes - 1) / kCostLanes * kCostLanes;
}

bool wide_sums(const MatchParams& params) noexcept {
  const int largest = params.prefilter_cap ? 2 * *params.prefilter_cap : 255;
  return !sums_fit_u16(params.block_width, params.block_height, largest);
}

// The left row with its border replicated: column k stands for x = k - before.
void extend_row(std::span<const std::uint8_t> row, int before,
                std::span<std::uint8_t> out) noexcept {
  const int last = static_cast<int>(row.size()) - 1;
  for (std::size_t k = 0; k < out.size(); ++k) {
    out[k] = row[size(std::clamp(static_cast<int>(k) - before, 0, last))];
  }
}

// The right row reversed, with its border replicated: element m stands for x = first - m.
void reverse_row(std::span<const std::uint8_t> row, int first,
                 std::span<std::uint8_t> out) noexcept {
  const int last = static_cast<int>(row.size()) - 1;
  for (std::size_t m = 0; m < out.size(); ++m) {
    out[m] = row[size(std::clamp(first - static_cast<int>(m), 0, last))];
  }
}

// kNoCost for candidates whose right column lies outside the image and for unused lanes.
template <typename Sum>
void mark_outside(int width, const MatchParams& params, int lanes, std::span<Sum> costs) noexcept {
  for (int x = 0; x < width; ++x) {
    const int farthest = x - params.min_disparity;  // the candidate that meets right column 0
    const int begin = std::clamp(farthest - width + 1, 0, lanes);
    const int end = std::clamp(std::min(params.disparities, farthest + 1), begin, lanes);
    const std::span<Sum> pixel = costs.subspan(size(x) * size(lanes), size(lanes));
    std::ranges::fill(pixel.first(size(begin)), kNoCost<Sum>);
    std::ranges::fill(pixel.subspan(size(end)), kNoCost<Sum>);
  }
}

// The columns at either end of the range have one candidate and no rival to judge it by: they take
// it where the next column found a match.
void settle_single_candidates(const MatchParams& params, std::span<std::int16_t> winners) noexcept {
  const int width = static_cast<int>(winners.size());
  const auto settle = [&](int x, int neighbour, int candidate) noexcept {
    if (std::min(x, neighbour) >= 0 && std::max(x, neighbour) < width &&
        winners[size(neighbour)] != kNoWinner) {
      winners[size(x)] = static_cast<std::int16_t>(candidate);
    }
  };
  if (params.disparities > 1) {
    const int first = params.min_disparity;  // meets right column 0 as candidate 0
    settle(first, first + 1, 0);
    const int last = width + params.min_disparity + params.disparities - 2;  // meets the last one
    settle(last, last - 1, params.disparities - 1);
  }
}

}  // namespace

Status check(const MatchParams& params, int width, int height) noexcept {
  const bool usable =
      width >= 1 && height >= 1 && params.disparities >= 1 && params.block_width >= 1 &&
      params.block_height >= 1 &&
      (!params.prefilter_cap || (*params.prefilter_cap >= 1 && *params.prefilter_cap <= 127)) &&
      (!params.left_right_tolerance || *params.left_right_tolerance >= 0);
  if (!usable) {
    return Status::kInvalidArgument;
  }
  const bool fits = width <= kMaxImageWidth && height <= kMaxImageWidth &&
                    params.disparities <= kMaxDisparities && params.block_width <= kMaxBlock &&
                    params.block_height <= kMaxBlock &&
                    std::abs(params.min_disparity) <= kMaxMinDisparity;
  return fits ? Status::kOk : Status::kTooLarge;
}

template <typename Sum>
struct Matcher::Buffers {
  std::span<std::uint8_t> new_left;
  std::span<std::uint8_t> new_right;
  std::span<std::uint8_t> old_left;
  std::span<std::uint8_t> old_right;
  std::span<Sum> columns;
  std::span<Sum> costs;
  std::span<Sum> right_costs;
  std::span<std::int16_t> winners;
  std::span<std::int16_t> right_winners;

  static std::size_t bytes(const MatchParams& params, int width) noexcept {
    const std::size_t lanes = size(lanes_of(params));
    const std::size_t columns = size(width + params.block_width - 1);
    const std::size_t right = size(width) + lanes - 1;
    return 2 * Arena::bytes_for<std::uint8_t>(columns) +
           2 * Arena::bytes_for<std::uint8_t>(columns + lanes - 1) +
           Arena::bytes_for<Sum>(columns * lanes) + Arena::bytes_for<Sum>(size(width) * lanes) +
           Arena::bytes_for<Sum>(right) + Arena::bytes_for<std::int16_t>(size(width)) +
           Arena::bytes_for<std::int16_t>(right);
  }

  Buffers(const MatchParams& params, int width, Arena arena) noexcept {
    const std::size_t lanes = size(lanes_of(params));
    const std::size_t n = size(width + params.block_width - 1);
    const std::size_t right = size(width) + lanes - 1;
    new_left = arena.take<std::uint8_t>(n);
    old_left = arena.take<std::uint8_t>(n);
    new_right = arena.take<std::uint8_t>(n + lanes - 1);
    old_right = arena.take<std::uint8_t>(n + lanes - 1);
    columns = arena.take<Sum>(n * lanes);
    costs = arena.take<Sum>(size(width) * lanes);
    right_costs = arena.take<Sum>(right);
    winners = arena.take<std::int16_t>(size(width));
    right_winners = arena.take<std::int16_t>(right);
  }
};

std::size_t Matcher::bytes_needed(const MatchParams& params, int width, int height) noexcept {
  const std::size_t row = wide_sums(params) ? Buffers<std::uint32_t>::bytes(params, width)
                                            : Buffers<std::uint16_t>::bytes(params, width);
  return 2 * Arena::bytes_for<std::uint8_t>(size(width) * size(height)) +
         Arena::bytes_for<std::byte>(row);
}

Matcher::Matcher(const MatchParams& params, int width, int height, Arena& arena) noexcept
    : params_(params), width_(width), height_(height) {
  STOF_CHECK(check(params, width, height) == Status::kOk);
  left_filtered_ = arena.take_image<std::uint8_t>(width, height);
  right_filtered_ = arena.take_image<std::uint8_t>(width, height);
  scratch_ =
      arena.take<std::byte>(wide_sums(params) ? Buffers<std::uint32_t>::bytes(params, width)
                                              : Buffers<std::uint16_t>::bytes(params, width));
}

void Matcher::match(ImageView<const std::uint8_t> left, ImageView<const std::uint8_t> right,
                    ImageView<Disparity> out) noexcept {
  prefilter(left, right, left.rows());
  match_rows(left, right, left.rows(), out);
}

void Matcher::prefilter(ImageView<const std::uint8_t> left, ImageView<const std::uint8_t> right,
                        Rows rows) noexcept {
  STOF_CHECK(same_size(left, right) && left.width() <= width_ && left.height() <= height_);
  if (!params_.prefilter_cap || left.empty()) {
    return;
  }
  const std::size_t width = size(left.width());
  for (int y = rows.begin; y < rows.end; ++y) {
    best::clipped_sobel(left.row_clamped(y - 1), left.row(y), left.row_clamped(y + 1),
                        *params_.prefilter_cap, left_filtered_.row(y).first(width));
    best::clipped_sobel(right.row_clamped(y - 1), right.row(y), right.row_clamped(y + 1),
                        *params_.prefilter_cap, right_filtered_.row(y).first(width));
  }
}

void Matcher::match_rows(ImageView<const std::uint8_t> left, ImageView<const std::uint8_t> right,
                         Rows rows, ImageView<Disparity> out) noexcept {
  STOF_CHECK(same_size(left, right) && same_size(left, out) && left.width() <= width_ &&
             left.height() <= height_ && rows.begin >= 0 && rows.end <= left.height());
  if (left.empty() || rows.count() <= 0) {
    return;
  }
  if (params_.prefilter_cap) {
    left =
        ImageView<const std::uint8_t>(left_filtered_.data(), left.width(), left.height(), width_);
    right =
        ImageView<const std::uint8_t>(right_filtered_.data(), left.width(), left.height(), width_);
  }
  if (wide_sums(params_)) {
    match_rows_with<std::uint32_t>(left, right, rows, out);
  } else {
    match_rows_with<std::uint16_t>(left, right, rows, out);
  }
}

template <typename Sum>
void Matcher::match_rows_with(ImageView<const std::uint8_t> left,
                              ImageView<const std::uint8_t> right, Rows rows,
                              ImageView<Disparity> out) noexcept {
  const int lanes = lanes_of(params_);
  const int before = params_.block_width / 2;
  const int above = params_.block_height / 2;
  const int below = params_.block_height - 1 - above;
  const Buffers<Sum> buffers(params_, left.width(), Arena(scratch_));
  // Column n - 1 meets candidate 0 at element 0 of the reversed row.
  const int first = left.width() + params_.block_width - 2 - before - params_.min_disparity;
  const auto load = [&](int y, std::span<std::uint8_t> left_row,
                        std::span<std::uint8_t> right_row) {
    extend_row(left.row_clamped(y), before, left_row);
    reverse_row(right.row_clamped(y), first, right_row);
  };
  std::ranges::fill(buffers.columns, Sum{0});
  for (int y = rows.begin - above; y <= rows.begin + below; ++y) {
    load(y, buffers.new_left, buffers.new_right);
    best::add_differences(buffers.new_left, buffers.new_right, lanes, buffers.columns);
  }
  for (int y = rows.begin; y < rows.end; ++y) {
    if (y > rows.begin) {
      load(y + below, buffers.new_left, buffers.new_right);
      load(y - 1 - above, buffers.old_left, buffers.old_right);
      best::slide_differences(buffers.new_left, buffers.new_right, buffers.old_left,
                              buffers.old_right, lanes, buffers.columns);
    }
    best::block_sums(std::span<const Sum>(buffers.columns), params_.block_width, lanes,
                     buffers.costs);
    mark_outside(left.width(), params_, lanes, buffers.costs);
    finish_row(buffers, lanes, out.row(y));
  }
}

template <typename Sum>
void Matcher::finish_row(const Buffers<Sum>& buffers, int lanes,
                         std::span<Disparity> out) noexcept {
  const std::span<const Sum> costs = buffers.costs;
  best::winners(costs, lanes, buffers.winners);
  settle_single_candidates(params_, buffers.winners);
  if (params_.left_right_tolerance) {
    best::right_winners(costs, lanes, buffers.right_costs, buffers.right_winners);
    best::left_right_check(buffers.right_winners, *params_.left_right_tolerance, buffers.winners);
  }
  if (params_.subpixel != Subpixel::kWhole) {
    best::refine_winners(costs, lanes, params_.min_disparity, buffers.winners, out);
  } else {
    best::whole_winners(params_.min_disparity, buffers.winners, out);
  }
}

}  // namespace stof::dsp
