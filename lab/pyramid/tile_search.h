#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

#include "dsp/base/arena.h"
#include "dsp/base/image.h"
#include "dsp/stereo/cost/cost_layout.h"
#include "dsp/stereo/search/block_winners.h"
#include "lab/match_params.h"
#include "lab/terms.h"

namespace stof::lab {

// Candidates first .. first + lanes - 1 of a picture's, lanes a multiple of kCostLanes.
struct CandidateRange {
  int first = 0;
  int lanes = 0;
};

// What a TileSearch finds, of the pictures' size: candidates, kNoWinner as in winner.h.
struct TileWinners {
  ImageView<std::int16_t> left;
  // Of right pixels, as RightWinners of winner.h among the candidates that left pixels searched;
  // empty: not wanted.
  ImageView<std::int16_t> right;
};

// Winner takes all on sums of absolute differences over fixed blocks, where parts of a picture
// search different candidates. Sum is u16 where sums_fit_u16(), else u32.
template <typename Sum>
class TileSearch {
 public:
  static constexpr int kTileWidth = 48;   // columns that share one range
  static constexpr int kTileHeight = 48;  // rows; search() takes any number
  static constexpr int kMerged = 8;       // tiles of a row that are searched as one at most

  static constexpr int tiles(int width) noexcept { return (width + kTileWidth - 1) / kTileWidth; }

  // params: block and disparities count, whatever else they say. check: right winners are wanted,
  // for at most kTileHeight rows at a time.
  TileSearch(const MatchParams& params, bool check, int width, int height, Arena& arena) noexcept;

  int lanes() const noexcept { return lanes_; }  // of all candidates

  // The pictures to compare, of the constructor's size: grey values or derivatives.
  void start(ImageView<const std::uint8_t> left, ImageView<const std::uint8_t> right) noexcept;

  // Fills `rows` of out. ranges: one for each of tiles(width), inside of 0 .. lanes(); neighbours
  // may be searched as one, so that a pixel can find a candidate outside of its tile's range.
  void search(Rows rows, std::span<const CandidateRange> ranges, const TileWinners& out) noexcept;

 private:
  struct Tile {
    int x;
    int width;
    CandidateRange range;
  };
  bool fused() const noexcept { return !fitted_.empty(); }
  int work(const Tile& tile) const noexcept;
  Tile merged(const Tile& a, const Tile& b) const noexcept;
  void search_tile(Rows rows, const Tile& tile, const TileWinners& out) noexcept;
  void search_fused(Rows rows, const Tile& tile, const TileWinners& out) noexcept;
  void start_columns(Rows rows, const Tile& tile, std::span<Sum> columns) noexcept;
  void mark_outside(const Tile& tile, std::span<Sum> costs) const noexcept;
  void find_right(const Tile& tile, std::span<const Sum> costs, std::span<Sum> lowest,
                  std::span<std::int16_t> winners) noexcept;
  std::span<const std::uint8_t> left_part(int y, const Tile& tile) const noexcept;
  std::span<const std::uint8_t> right_part(int y, const Tile& tile) const noexcept;

  int min_disparity_;
  int disparities_;
  int lanes_;
  int block_width_;
  int block_height_;
  CostColumns around_;
  ImageView<std::uint8_t> left_;   // widened by the block
  ImageView<std::uint8_t> right_;  // and reversed
  std::span<Sum> columns_;
  std::span<Sum> costs_;
  std::span<Disparity> fitted_;  // empty where block_winners() does not serve
  ImageView<Sum> lowest_;        // of the right pixels of the rows at work
  std::span<Sum> tile_lowest_;
  std::span<std::int16_t> tile_winners_;
};

}  // namespace stof::lab
