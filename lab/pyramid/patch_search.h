#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

#include "dsp/base/arena.h"
#include "dsp/base/image.h"
#include "dsp/stereo/cost/cost_layout.h"
#include "dsp/stereo/search/block_winners.h"
#include "lab/dsp_names.h"
#include "lab/match_params.h"

namespace stof::lab {

// Candidates first .. first + lanes - 1 of a picture's, lanes a multiple of kCostLanes.
struct CandidateRange {
  int first = 0;
  int lanes = 0;
};

// The results of a PatchSearch, as large as the pictures: candidates, kNoWinner as in winner.h.
struct PatchWinners {
  ImageView<std::int16_t> left;
  // Winners of right pixels, as RightWinners of winner.h, among the candidates that left pixels
  // searched; empty: not wanted.
  ImageView<std::int16_t> right;
};

// Winner takes all on sums of absolute differences over fixed blocks, where parts of a picture
// search different candidates. Sum is u16 where sums_fit_u16(), else u32.
template <typename Sum>
class PatchSearch {
 public:
  static constexpr int kPatchWidth = 48;   // columns that share one range
  static constexpr int kPatchHeight = 48;  // rows; search() takes any number
  static constexpr int kMerged = 8;        // patches of a row that are searched as one at most

  static constexpr int patches(int width) noexcept {
    return (width + kPatchWidth - 1) / kPatchWidth;
  }

  // params: block and disparities count, whatever else they say. check: right winners are wanted,
  // for at most kPatchHeight rows at a time.
  PatchSearch(const MatchParams& params, bool check, int width, int height, Arena& arena) noexcept;

  int lanes() const noexcept { return lanes_; }  // of all candidates

  // The pictures to compare, of the constructor's size: grey values or derivatives.
  void start(ImageView<const std::uint8_t> left, ImageView<const std::uint8_t> right) noexcept;

  // Fills `rows` of out. ranges: one for each of patches(width), inside of 0 .. lanes(); neighbours
  // may be searched as one, so that a pixel can find a candidate outside of its patch's range.
  void search(Rows rows, std::span<const CandidateRange> ranges, const PatchWinners& out) noexcept;

 private:
  struct Patch {
    int x;
    int width;
    CandidateRange range;
  };
  bool fused() const noexcept { return !fitted_.empty(); }
  int work(const Patch& patch) const noexcept;
  Patch merged(const Patch& a, const Patch& b) const noexcept;
  void search_patch(Rows rows, const Patch& patch, const PatchWinners& out) noexcept;
  void search_fused(Rows rows, const Patch& patch, const PatchWinners& out) noexcept;
  void start_columns(Rows rows, const Patch& patch, std::span<Sum> columns) noexcept;
  void mark_outside(const Patch& patch, std::span<Sum> costs) const noexcept;
  void find_right(const Patch& patch, std::span<const Sum> costs, std::span<Sum> lowest,
                  std::span<std::int16_t> winners) noexcept;
  std::span<const std::uint8_t> left_part(int y, const Patch& patch) const noexcept;
  std::span<const std::uint8_t> right_part(int y, const Patch& patch) const noexcept;

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
  std::span<Sum> patch_lowest_;
  std::span<std::int16_t> patch_winners_;
};

}  // namespace stof::lab
