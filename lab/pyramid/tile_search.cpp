#include "lab/pyramid/tile_search.h"

#include <algorithm>
#include <type_traits>

#include "dsp/base/check.h"
#include "dsp/base/index.h"
#include "dsp/base/target.h"
#include "dsp/stereo/cost/sad.h"
#include "dsp/stereo/search/winner.h"
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
TileSearch<Sum>::TileSearch(const MatchParams& params, bool check, int width, int height,
                            Arena& arena) noexcept
    : min_disparity_(params.min_disparity),
      disparities_(params.disparities),
      lanes_(lanes_of(params)),
      block_width_(params.block_width),
      block_height_(params.block_height),
      around_(block_columns(params)) {
  const int columns = width + block_width_ - 1;
  const int widest = std::min(width, kMerged * kTileWidth);
  const std::size_t right = index(check ? widest + lanes_ - 1 : 0);
  left_ = arena.take_image<std::uint8_t>(columns, height);
  right_ = arena.take_image<std::uint8_t>(columns + lanes_ - 1, height);
  columns_ = arena.take<Sum>(index(widest + block_width_ - 1) * index(lanes_));
  costs_ = arena.take<Sum>(index(widest) * index(lanes_) + 2 * kBlockCostMargin)
               .subspan(kBlockCostMargin, index(widest) * index(lanes_));
  fitted_ = arena.take<Disparity>(index(fuses<Sum>(params) ? widest : 0));
  lowest_ = arena.take_image<Sum>(check ? width : 0, kTileHeight);
  tile_lowest_ = arena.take<Sum>(right);
  tile_winners_ = arena.take<std::int16_t>(right);
}

template <typename Sum>
void TileSearch<Sum>::start(ImageView<const std::uint8_t> left,
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
int TileSearch<Sum>::work(const Tile& tile) const noexcept {
  return (tile.width + block_width_ - 1) * tile.range.lanes;
}

template <typename Sum>
auto TileSearch<Sum>::merged(const Tile& a, const Tile& b) const noexcept -> Tile {
  const int first = std::min(a.range.first, b.range.first);
  const int end = std::max(a.range.first + a.range.lanes, b.range.first + b.range.lanes);
  const int lanes = whole_lanes(end - first);
  return {a.x, a.width + b.width, {std::min(first, lanes_ - lanes), lanes}};
}

template <typename Sum>
void TileSearch<Sum>::search(Rows rows, std::span<const CandidateRange> ranges,
                             const TileWinners& out) noexcept {
  const int width = left_.width() - block_width_ + 1;
  const bool check = !out.right.empty();
  STOF_CHECK(static_cast<int>(ranges.size()) == tiles(width));
  STOF_CHECK(!check || (rows.count() <= kTileHeight && lowest_.width() == width));
  for (int y = rows.begin; check && y < rows.end; ++y) {
    std::ranges::fill(lowest_.row(y - rows.begin), kNoCost<Sum>);
    std::ranges::fill(out.right.row(y), kNoWinner);
  }
  const auto tile_at = [&](int t) noexcept -> Tile {
    const int x = t * kTileWidth;
    return {x, std::min(kTileWidth, width - x), ranges[index(t)]};
  };
  for (int t = 0; t < tiles(width);) {
    Tile tile = tile_at(t++);
    for (int count = 1; t < tiles(width) && count < kMerged; ++count, ++t) {
      const Tile next = tile_at(t);
      const Tile both = merged(tile, next);
      if (work(both) > work(tile) + work(next)) {
        break;
      }
      tile = both;
    }
    if (fused()) {
      search_fused(rows, tile, out);
    } else {
      search_tile(rows, tile, out);
    }
  }
}

template <typename Sum>
std::span<const std::uint8_t> TileSearch<Sum>::left_part(int y, const Tile& tile) const noexcept {
  return left_.row_clamped(y).subspan(index(tile.x), index(tile.width + block_width_ - 1));
}

// Element n - 1 - k + i of the row meets column k as candidate i (cost_layout.h).
template <typename Sum>
std::span<const std::uint8_t> TileSearch<Sum>::right_part(int y, const Tile& tile) const noexcept {
  const int last = tile.x + tile.width + block_width_ - 2;
  return right_.row_clamped(y).subspan(index(left_.width() - 1 - last + tile.range.first),
                                       index(tile.width + block_width_ - 1 + tile.range.lanes - 1));
}

// The column sums of the block around the first of these rows.
template <typename Sum>
void TileSearch<Sum>::start_columns(Rows rows, const Tile& tile, std::span<Sum> columns) noexcept {
  const int first = rows.begin - block_height_ / 2;
  std::ranges::fill(columns, Sum{0});
  for (int y = first; y < first + block_height_; ++y) {
    best::add_differences(left_part(y, tile), right_part(y, tile), tile.range.lanes, columns);
  }
}

template <typename Sum>
void TileSearch<Sum>::search_fused(Rows rows, const Tile& tile, const TileWinners& out) noexcept {
  if constexpr (std::is_same_v<Sum, std::uint16_t>) {
    const int lanes = tile.range.lanes;
    const int above = block_height_ / 2;
    const int below = block_height_ - 1 - above;
    const std::span<Sum> columns =
        columns_.first(index(tile.width + block_width_ - 1) * index(lanes));
    start_columns(rows, tile, columns);
    for (Sum& sum : columns) {
      sum = static_cast<Sum>(sum * kBlockSumScale);
    }
    const bool check = !out.right.empty();
    const std::span<Sum> costs = costs_.first(index(check ? tile.width : 0) * index(lanes));
    const BlockRow row{.block_width = block_width_,
                       .lanes = lanes,
                       .disparities = std::min(lanes, disparities_ - tile.range.first),
                       .min_disparity = min_disparity_ + tile.range.first,
                       .x = tile.x,
                       .right_width = left_.width() - block_width_ + 1,
                       .fit = CostFit::kNone};
    for (int y = rows.begin; y < rows.end; ++y) {
      // Nothing slides to the first row: the same pixels enter and leave.
      const int leaving = y > rows.begin ? y - 1 - above : y + below;
      const std::span<std::int16_t> winners =
          out.left.row(y).subspan(index(tile.x), index(tile.width));
      best::block_winners(
          {.new_left = left_part(y + below, tile),
           .new_right = right_part(y + below, tile),
           .old_left = left_part(leaving, tile),
           .old_right = right_part(leaving, tile)},
          row, columns,
          {.winners = winners, .fitted = fitted_.first(index(tile.width)), .costs = costs});
      number_from(tile.range.first, winners);
      if (check) {
        find_right(tile, costs, lowest_.row(y - rows.begin), out.right.row(y));
      }
    }
  }
}

template <typename Sum>
void TileSearch<Sum>::search_tile(Rows rows, const Tile& tile, const TileWinners& out) noexcept {
  const int lanes = tile.range.lanes;
  const int above = block_height_ / 2;
  const int below = block_height_ - 1 - above;
  const std::span<Sum> columns =
      columns_.first(index(tile.width + block_width_ - 1) * index(lanes));
  const std::span<Sum> costs = costs_.first(index(tile.width) * index(lanes));
  start_columns(rows, tile, columns);
  for (int y = rows.begin; y < rows.end; ++y) {
    if (y > rows.begin) {
      const int leaving = y - 1 - above;
      best::slide_differences(left_part(y + below, tile), right_part(y + below, tile),
                              left_part(leaving, tile), right_part(leaving, tile), lanes, columns);
    }
    best::block_sums(std::span<const Sum>(columns), block_width_, lanes, costs);
    mark_outside(tile, costs);
    const std::span<std::int16_t> winners =
        out.left.row(y).subspan(index(tile.x), index(tile.width));
    best::winners(std::span<const Sum>(costs), lanes, winners);
    number_from(tile.range.first, winners);
    if (!out.right.empty()) {
      find_right(tile, costs, lowest_.row(y - rows.begin), out.right.row(y));
    }
  }
}

template <typename Sum>
void TileSearch<Sum>::mark_outside(const Tile& tile, std::span<Sum> costs) const noexcept {
  const int width = left_.width() - block_width_ + 1;
  const int lanes = tile.range.lanes;
  const int unused = disparities_ - tile.range.first;              // lanes from here on
  const int nearest = tile.x - min_disparity_ - tile.range.first;  // right column of candidate 0
  if (unused >= lanes && nearest - lanes + 1 >= 0 && nearest + tile.width <= width) {
    return;
  }
  for (int x = tile.x; x < tile.x + tile.width; ++x) {
    // The candidate that meets right column 0.
    const int farthest = x - min_disparity_ - tile.range.first;
    const int begin = std::clamp(farthest - width + 1, 0, lanes);
    const int end = std::clamp(std::min(unused, farthest + 1), begin, lanes);
    if (begin > 0 || end < lanes) {
      const std::span<Sum> pixel = costs.subspan(index(x - tile.x) * index(lanes), index(lanes));
      std::ranges::fill(pixel.first(index(begin)), kNoCost<Sum>);
      std::ranges::fill(pixel.subspan(index(end)), kNoCost<Sum>);
    }
  }
}

// Tiles come from the left, so that an equal cost of a later one is of a larger candidate.
template <typename Sum>
void TileSearch<Sum>::find_right(const Tile& tile, std::span<const Sum> costs,
                                 std::span<Sum> lowest, std::span<std::int16_t> winners) noexcept {
  const int count = tile.width + tile.range.lanes - 1;
  const std::span<Sum> found = tile_lowest_.first(index(count));
  best::right_winners(costs, tile.range.lanes, found, tile_winners_.first(index(count)));
  const int first = tile.x + tile.width - 1 - min_disparity_ - tile.range.first;
  const int width = static_cast<int>(lowest.size());
  for (int j = std::max(0, first - width + 1); j < std::min(count, first + 1); ++j) {
    const std::size_t column = index(first - j);
    if (found[index(j)] < lowest[column]) {
      lowest[column] = found[index(j)];
      winners[column] = static_cast<std::int16_t>(tile_winners_[index(j)] + tile.range.first);
    }
  }
}

template class TileSearch<std::uint16_t>;
template class TileSearch<std::uint32_t>;

}  // namespace stof::lab
