#include "lab/pyramid/patch_strips.h"

#include <algorithm>

#include "dsp/base/check.h"
#include "dsp/base/index.h"
#include "dsp/base/target.h"

namespace stof::lab {
namespace {

int left_columns(const MatchParams& params, int width) noexcept {
  return (PatchStrips::patches(width) - 1) * kPatchColumns + patch_reach(params.block_width);
}

int right_columns(const MatchParams& params, int width) noexcept {
  return left_columns(params, width) + params.disparities - 1;
}

// Element e stands for x = e - shift; borders replicate.
void widen_row(std::span<const std::uint8_t> row, int shift, std::span<std::uint8_t> out) noexcept {
  const int count = static_cast<int>(out.size());
  const int begin = std::clamp(shift, 0, count);
  const int end = std::clamp(shift + static_cast<int>(row.size()), begin, count);
  std::ranges::fill(out.first(index(begin)), row.front());
  if (begin < end) {
    std::ranges::copy(row.subspan(index(begin - shift), index(end - begin)), out.begin() + begin);
  }
  std::ranges::fill(out.subspan(index(end)), row.back());
}

}  // namespace

bool PatchStrips::serves(const MatchParams& params) noexcept {
  return params.prefilter_cap &&
         patch_sums_serve(params.block_width, params.block_height, 2 * *params.prefilter_cap);
}

PatchStrips::PatchStrips(const MatchParams& params, bool check, int width, int height,
                         Arena& arena) noexcept
    : width_(width),
      min_disparity_(params.min_disparity),
      disparities_(params.disparities),
      block_width_(params.block_width),
      block_height_(params.block_height),
      left_(arena.take_image<std::uint8_t>(left_columns(params, width), height)),
      right_(arena.take_image<std::uint8_t>(right_columns(params, width), height)),
      sums_(arena.take<std::uint16_t>(index(params.disparities * kPatchColumns))),
      lowest_(arena.take_image<std::uint16_t>(check ? width : 0, kPatchHeight)) {
  STOF_CHECK(serves(params));
}

void PatchStrips::start(ImageView<const std::uint8_t> left,
                        ImageView<const std::uint8_t> right) noexcept {
  STOF_CHECK(same_size(left, right) && left.width() == width_ && left.height() == left_.height());
  const int before = block_width_ / 2;
  for (int y = 0; y < left.height(); ++y) {
    widen_row(left.row(y), before, left_.row(y));
    widen_row(right.row(y), before + min_disparity_ + disparities_ - 1, right_.row(y));
  }
}

PatchPlace PatchStrips::place_of(int t, std::span<const std::int16_t> candidates) const noexcept {
  const int x = t * kPatchColumns;
  return {.left = left_,
          .right = right_,
          .left_x = x,
          .right_x = x + disparities_ - 1,
          .block_width = block_width_,
          .candidates = candidates};
}

PatchLimits PatchStrips::limits_of(int t) const noexcept {
  const int begin = min_disparity_ - t * kPatchColumns;
  return {begin, begin + width_};
}

void PatchStrips::search(Rows rows, int t, std::span<const std::int16_t> candidates,
                         const PatchWinners& out) noexcept {
  const bool check = !out.right.empty();
  STOF_CHECK(!check || (rows.count() <= kPatchHeight && lowest_.width() == width_));
  for (int y = rows.begin; check && t == 0 && y < rows.end; ++y) {
    std::ranges::fill(lowest_.row(y - rows.begin), kNoCost<std::uint16_t>);
    std::ranges::fill(out.right.row(y), kNoWinner);
  }
  const int x = t * kPatchColumns;
  const int width = std::min(kPatchColumns, width_ - x);
  const PatchPlace patch = place_of(t, candidates);
  const std::span<std::uint16_t> sums = sums_.first(candidates.size() * kPatchColumns);
  const PatchLimits limits = limits_of(t);
  const int above = block_height_ / 2;
  const int below = block_height_ - 1 - above;
  best::start_patch(patch, {rows.begin - above, rows.begin + below + 1}, sums);
  for (int y = rows.begin; y < rows.end; ++y) {
    if (y > rows.begin) {
      best::slide_patch(patch, y + below, y - 1 - above, sums);
    }
    best::find_in_patch(sums, candidates, limits, out.left.row(y).subspan(index(x), index(width)));
    if (check) {
      find_right(x, width, candidates, lowest_.row(y - rows.begin), out.right.row(y));
    }
  }
}

void PatchStrips::search_quarter(Rows rows, int t, std::span<const std::int16_t> candidates,
                                 ImageView<std::int16_t> out) const noexcept {
  STOF_CHECK(rows.begin % 2 == 0 && out.width() == (width_ + 1) / 2);
  const int column = t * kQuarterColumns;
  const ImageView<std::int16_t> part(out.row(rows.begin / 2).data() + column,
                                     std::min(kQuarterColumns, out.width() - column),
                                     (rows.count() + 1) / 2, out.stride());
  best::find_quarter(place_of(t, candidates), rows, block_height_, limits_of(t), part);
}

// Patches come from the left, so that an equal cost of a later one is of a larger candidate.
void PatchStrips::find_right(int x, int width, std::span<const std::int16_t> candidates,
                             std::span<std::uint16_t> lowest,
                             std::span<std::int16_t> winners) const noexcept {
  for (std::size_t i = 0; i < candidates.size(); ++i) {
    const int shift = x - min_disparity_ - candidates[i];  // right column of the patch's column 0
    const int begin = std::clamp(-shift, 0, width);
    const int end = std::clamp(width_ - shift, begin, width);
    const std::size_t count = index(end - begin);
    if (count > 0) {
      best::offer_to_right(sums_.subspan(i * kPatchColumns + index(begin), count), candidates[i],
                           lowest.subspan(index(shift + begin), count),
                           winners.subspan(index(shift + begin), count));
    }
  }
}

}  // namespace stof::lab
