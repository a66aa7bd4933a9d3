#include "lab/pyramid/patch_search.h"

#include <algorithm>
#include <type_traits>

#include "dsp/base/check.h"
#include "dsp/base/index.h"
#include "dsp/base/target.h"
#include "dsp/stereo/cost/sad.h"
#include "dsp/stereo/search/winner.h"
#include "lab/cost/cost_sums.h"
#include "lab/search/energy.h"

namespace stof::lab {
namespace {

constexpr int whole_lanes(int candidates) noexcept {
  return (candidates + kCostLanes - 1) / kCostLanes * kCostLanes;
}

// Winners among all candidates, from those of a range.
void number_from(int first, std::span<std::int16_t> winners) noexcept {
  for (std::int16_t& winner : winners) {
    winner = winner == kNoWinner ? kNoWinner : static_cast<std::int16_t>(winner + first);
  }
}

// Whether block_winners() does it all.
template <typename Sum>
bool fuses(const MatchParams& params) noexcept {
  return std::is_same_v<Sum, std::uint16_t> &&
         block_winners_serve(params.block_width, params.block_height, largest_difference(params));
}

}  // namespace

template <typename Sum>
PatchSearch<Sum>::PatchSearch(const MatchParams& params, bool check, int width, int height,
                              Arena& arena) noexcept
    : min_disparity_(params.min_disparity),
      disparities_(params.disparities),
      lanes_(lanes_of(params)),
      block_width_(params.block_width),
      block_height_(params.block_height),
      around_(block_columns(params)) {
  const int columns = width + block_width_ - 1;
  const int widest = std::min(width, kMerged * kPatchWidth);
  const std::size_t right = index(check ? widest + lanes_ - 1 : 0);
  left_ = arena.take_image<std::uint8_t>(columns, height);
  right_ = arena.take_image<std::uint8_t>(columns + lanes_ - 1, height);
  columns_ = arena.take<Sum>(index(widest + block_width_ - 1) * index(lanes_));
  costs_ = arena.take<Sum>(index(widest) * index(lanes_) + 2 * kBlockCostMargin)
               .subspan(kBlockCostMargin, index(widest) * index(lanes_));
  fitted_ = arena.take<Disparity>(index(fuses<Sum>(params) ? widest : 0));
  lowest_ = arena.take_image<Sum>(check ? width : 0, kPatchHeight);
  patch_lowest_ = arena.take<Sum>(right);
  patch_winners_ = arena.take<std::int16_t>(right);
}

template <typename Sum>
void PatchSearch<Sum>::start(ImageView<const std::uint8_t> left,
                             ImageView<const std::uint8_t> right) noexcept {
  STOF_CHECK(same_size(left, right) && left.width() == left_.width() - block_width_ + 1 &&
             left.height() == left_.height());
  for (int y = 0; y < left.height(); ++y) {
    extend_row(left.row(y), around_, left_.row(y));
    reverse_row(right.row(y), around_, min_disparity_, right_.row(y));
  }
}

// Differences to compute for each of its rows.
template <typename Sum>
int PatchSearch<Sum>::work(const Patch& patch) const noexcept {
  return (patch.width + block_width_ - 1) * patch.range.lanes;
}

template <typename Sum>
auto PatchSearch<Sum>::merged(const Patch& a, const Patch& b) const noexcept -> Patch {
  const int first = std::min(a.range.first, b.range.first);
  const int end = std::max(a.range.first + a.range.lanes, b.range.first + b.range.lanes);
  const int lanes = whole_lanes(end - first);
  return {a.x, a.width + b.width, {std::min(first, lanes_ - lanes), lanes}};
}

template <typename Sum>
void PatchSearch<Sum>::search(Rows rows, std::span<const CandidateRange> ranges,
                              const PatchWinners& out) noexcept {
  const int width = left_.width() - block_width_ + 1;
  const bool check = !out.right.empty();
  STOF_CHECK(static_cast<int>(ranges.size()) == patches(width));
  STOF_CHECK(!check || (rows.count() <= kPatchHeight && lowest_.width() == width));
  for (int y = rows.begin; check && y < rows.end; ++y) {
    std::ranges::fill(lowest_.row(y - rows.begin), kNoCost<Sum>);
    std::ranges::fill(out.right.row(y), kNoWinner);
  }
  const auto patch_at = [&](int t) noexcept -> Patch {
    const int x = t * kPatchWidth;
    return {x, std::min(kPatchWidth, width - x), ranges[index(t)]};
  };
  for (int t = 0; t < patches(width);) {
    Patch patch = patch_at(t++);
    for (int count = 1; t < patches(width) && count < kMerged; ++count, ++t) {
      const Patch next = patch_at(t);
      const Patch both = merged(patch, next);
      if (work(both) > work(patch) + work(next)) {
        break;
      }
      patch = both;
    }
    if (fused()) {
      search_fused(rows, patch, out);
    } else {
      search_patch(rows, patch, out);
    }
  }
}

template <typename Sum>
std::span<const std::uint8_t> PatchSearch<Sum>::left_part(int y,
                                                          const Patch& patch) const noexcept {
  return left_.row_clamped(y).subspan(index(patch.x), index(patch.width + block_width_ - 1));
}

// Element n - 1 - k + i of the row meets column k as candidate i (cost_layout.h).
template <typename Sum>
std::span<const std::uint8_t> PatchSearch<Sum>::right_part(int y,
                                                           const Patch& patch) const noexcept {
  const int last = patch.x + patch.width + block_width_ - 2;
  return right_.row_clamped(y).subspan(
      index(left_.width() - 1 - last + patch.range.first),
      index(patch.width + block_width_ - 1 + patch.range.lanes - 1));
}

// The column sums of the block around the first of these rows.
template <typename Sum>
void PatchSearch<Sum>::start_columns(Rows rows, const Patch& patch,
                                     std::span<Sum> columns) noexcept {
  const int first = rows.begin - block_height_ / 2;
  std::ranges::fill(columns, Sum{0});
  for (int y = first; y < first + block_height_; ++y) {
    best::add_differences(left_part(y, patch), right_part(y, patch), patch.range.lanes, columns);
  }
}

template <typename Sum>
void PatchSearch<Sum>::search_fused(Rows rows, const Patch& patch,
                                    const PatchWinners& out) noexcept {
  if constexpr (std::is_same_v<Sum, std::uint16_t>) {
    const int lanes = patch.range.lanes;
    const int above = block_height_ / 2;
    const int below = block_height_ - 1 - above;
    const std::span<Sum> columns =
        columns_.first(index(patch.width + block_width_ - 1) * index(lanes));
    start_columns(rows, patch, columns);
    for (Sum& sum : columns) {
      sum = static_cast<Sum>(sum * kBlockSumScale);
    }
    const bool check = !out.right.empty();
    const std::span<Sum> costs = costs_.first(index(check ? patch.width : 0) * index(lanes));
    const BlockRow row{.block_width = block_width_,
                       .lanes = lanes,
                       .disparities = std::min(lanes, disparities_ - patch.range.first),
                       .min_disparity = min_disparity_ + patch.range.first,
                       .x = patch.x,
                       .right_width = left_.width() - block_width_ + 1,
                       .fit = CostFit::kNone};
    for (int y = rows.begin; y < rows.end; ++y) {
      // Nothing slides to the first row: the same pixels enter and leave.
      const int leaving = y > rows.begin ? y - 1 - above : y + below;
      const std::span<std::int16_t> winners =
          out.left.row(y).subspan(index(patch.x), index(patch.width));
      best::block_winners(
          {.new_left = left_part(y + below, patch),
           .new_right = right_part(y + below, patch),
           .old_left = left_part(leaving, patch),
           .old_right = right_part(leaving, patch)},
          row, columns,
          {.winners = winners, .fitted = fitted_.first(index(patch.width)), .costs = costs});
      number_from(patch.range.first, winners);
      if (check) {
        find_right(patch, costs, lowest_.row(y - rows.begin), out.right.row(y));
      }
    }
  }
}

template <typename Sum>
void PatchSearch<Sum>::search_patch(Rows rows, const Patch& patch,
                                    const PatchWinners& out) noexcept {
  const int lanes = patch.range.lanes;
  const int above = block_height_ / 2;
  const int below = block_height_ - 1 - above;
  const std::span<Sum> columns =
      columns_.first(index(patch.width + block_width_ - 1) * index(lanes));
  const std::span<Sum> costs = costs_.first(index(patch.width) * index(lanes));
  start_columns(rows, patch, columns);
  for (int y = rows.begin; y < rows.end; ++y) {
    if (y > rows.begin) {
      const int leaving = y - 1 - above;
      best::slide_differences(left_part(y + below, patch), right_part(y + below, patch),
                              left_part(leaving, patch), right_part(leaving, patch), lanes,
                              columns);
    }
    best::block_sums(std::span<const Sum>(columns), block_width_, lanes, costs);
    mark_outside(patch, costs);
    const std::span<std::int16_t> winners =
        out.left.row(y).subspan(index(patch.x), index(patch.width));
    best::winners(std::span<const Sum>(costs), lanes, winners);
    number_from(patch.range.first, winners);
    if (!out.right.empty()) {
      find_right(patch, costs, lowest_.row(y - rows.begin), out.right.row(y));
    }
  }
}

template <typename Sum>
void PatchSearch<Sum>::mark_outside(const Patch& patch, std::span<Sum> costs) const noexcept {
  const int width = left_.width() - block_width_ + 1;
  const int lanes = patch.range.lanes;
  const int unused = disparities_ - patch.range.first;               // lanes from here on
  const int nearest = patch.x - min_disparity_ - patch.range.first;  // right column of candidate 0
  if (unused >= lanes && nearest - lanes + 1 >= 0 && nearest + patch.width <= width) {
    return;
  }
  for (int x = patch.x; x < patch.x + patch.width; ++x) {
    // The candidate that meets right column 0.
    const int farthest = x - min_disparity_ - patch.range.first;
    const int begin = std::clamp(farthest - width + 1, 0, lanes);
    const int end = std::clamp(std::min(unused, farthest + 1), begin, lanes);
    if (begin > 0 || end < lanes) {
      const std::span<Sum> pixel = costs.subspan(index(x - patch.x) * index(lanes), index(lanes));
      std::ranges::fill(pixel.first(index(begin)), kNoCost<Sum>);
      std::ranges::fill(pixel.subspan(index(end)), kNoCost<Sum>);
    }
  }
}

// Patches come from the left, so that an equal cost of a later one is of a larger candidate.
template <typename Sum>
void PatchSearch<Sum>::find_right(const Patch& patch, std::span<const Sum> costs,
                                  std::span<Sum> lowest, std::span<std::int16_t> winners) noexcept {
  const int count = patch.width + patch.range.lanes - 1;
  const std::span<Sum> found = patch_lowest_.first(index(count));
  best::right_winners(costs, patch.range.lanes, found, patch_winners_.first(index(count)));
  const int first = patch.x + patch.width - 1 - min_disparity_ - patch.range.first;
  const int width = static_cast<int>(lowest.size());
  for (int j = std::max(0, first - width + 1); j < std::min(count, first + 1); ++j) {
    const std::size_t column = index(first - j);
    if (found[index(j)] < lowest[column]) {
      lowest[column] = found[index(j)];
      winners[column] = static_cast<std::int16_t>(patch_winners_[index(j)] + patch.range.first);
    }
  }
}

template class PatchSearch<std::uint16_t>;
template class PatchSearch<std::uint32_t>;

}  // namespace stof::lab
