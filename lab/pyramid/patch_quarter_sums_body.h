#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>

#include "dsp/base/check.h"
#include "dsp/stereo/match_params.h"
#include "lab/pyramid/patch_quarter_boxes_body.h"

namespace stof::dsp::patch_quarter_body {

// The sums of some candidates of a patch, of every second column. Isa, kBlock: of
// patch_quarter_boxes_body.h.
template <typename Isa, std::size_t kBlock>
class QuarterSums {
 public:
  using Boxes = QuarterBoxes<Isa, kBlock>;
  static constexpr std::size_t kBytes = Boxes::kBytes;
  static constexpr std::size_t kSums = Boxes::kSums;
  static constexpr std::size_t kOuts = Boxes::kOuts;
  static constexpr std::size_t kLine = Boxes::kLine;
  static constexpr std::size_t kGroup = kPatchSumScale;  // candidates that are worked on together

  // rows: those that blocks are around.
  QuarterSums(const PatchPlace& patch, int block_height, Rows rows) noexcept
      : candidates_(patch.candidates), boxes_(patch.block_width), height_(block_height) {
    const int begin = rows.begin - block_height / 2;
    const int count = rows.count() - 1 + block_height;
    STOF_CHECK(count <= static_cast<int>(kRows));
    for (int k = 0; k < count; ++k) {
      left_[k] = patch.left.row_clamped(begin + k).data() + patch.left_x;
      right_[k] = patch.right.row_clamped(begin + k).data() + patch.right_x;
    }
  }

  // keep(i, v, sums): each vector of sums of `count` candidates.
  template <typename Keep>
  void tell(std::size_t count, Keep keep) const noexcept {
    for (std::size_t i = 0; i < count; ++i) {
      for (std::size_t v = 0; v < kOuts; ++v) {
        keep(i, v, Isa::load(sums_[i] + v * kSums));
      }
    }
  }

  // Takes `count` candidates from place `first` on, around the first row.
  void start(std::size_t first, std::size_t count) noexcept {
    for (std::size_t i = 0; i < count; ++i) {
      typename Boxes::Pairs pairs;
      for (int y = 0; y < height_; y += kFit) {
        Bytes total[kMostParts];
        std::ranges::fill(total, Isa::zero());
        for (int k = y; k < std::min(y + kFit, height_); ++k) {
          const std::uint8_t* const met = right_[k] - candidates_[first + i];
          for (std::size_t p = 0; p < boxes_.parts(); ++p) {
            total[p] = Isa::plus(total[p], Isa::difference(Isa::load_bytes(left_[k] + p * kBytes),
                                                           Isa::load_bytes(met + p * kBytes)));
          }
        }
        boxes_.add(total, pairs);
      }
      Sums boxes[kMostParts];
      boxes_.sum(pairs, boxes);
      for (std::size_t v = 0; v < kOuts; ++v) {
        Isa::store(sums_[i] + v * kSums,
                   Isa::add(boxes[v], Isa::all(static_cast<std::uint16_t>(i))));
      }
    }
  }

  // To row 2 r from the one before. keep as in tell().
  template <typename Keep>
  void slide(int r, std::size_t first, std::size_t count, Keep keep) noexcept {
    const int leaving = 2 * r - 2;
    const int entering = leaving + height_;
    const std::uint8_t* const left[4] = {left_[leaving], left_[leaving + 1], left_[entering],
                                         left_[entering + 1]};
    const std::uint8_t* const right = right_[leaving];
    const std::ptrdiff_t rows[4] = {0, right_[leaving + 1] - right, right_[entering] - right,
                                    right_[entering + 1] - right};
    Bytes pixels[4][kMostParts];
    for (std::size_t k = 0; k < 4; ++k) {
      for (std::size_t p = 0; p < boxes_.parts(); ++p) {
        pixels[k][p] = Isa::load_bytes(left[k] + p * kBytes);
      }
    }
    const std::int16_t* const candidates = candidates_.data() + first;
    for (std::size_t i = 0; i < count; ++i) {
      const std::uint8_t* const met = right - candidates[i];
      Bytes change[kMostParts];
      for (std::size_t p = 0; p < boxes_.parts(); ++p) {
        const auto row = [&](std::size_t k) noexcept {
          return Isa::difference(pixels[k][p], Isa::load_bytes(met + rows[k] + p * kBytes));
        };
        change[p] = Isa::minus(Isa::plus(row(2), row(3)), Isa::plus(row(0), row(1)));
      }
      Sums boxes[kMostParts];
      boxes_.sum_small(change, boxes);
      for (std::size_t v = 0; v < kOuts; ++v) {
        const Sums sum = Isa::add(Isa::load(sums_[i] + v * kSums), boxes[v]);
        Isa::store(sums_[i] + v * kSums, sum);
        keep(i, v, sum);
      }
    }
  }

 private:
  using Bytes = typename Isa::Bytes;
  using Sums = typename Isa::Sums;
  static constexpr std::size_t kMostParts = Boxes::kMostParts;

  static constexpr std::size_t kRows = 2 * kQuarterRows - 1 + kMaxBlock;
  static constexpr int kFit = 127 / kLargestPatchPixel;  // differences that fit a byte with a sign

  std::span<const std::int16_t> candidates_;
  Boxes boxes_;
  int height_;
  const std::uint8_t* left_[kRows];   // the patch's first column
  const std::uint8_t* right_[kRows];  // and what it meets as candidate 0
  alignas(64) std::uint16_t sums_[kGroup][kLine];
};

}  // namespace stof::dsp::patch_quarter_body
