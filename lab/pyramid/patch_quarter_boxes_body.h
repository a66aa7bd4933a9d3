#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>

#include "lab/pyramid/patch_sums_body.h"

namespace stof::dsp::patch_quarter_body {

// Sums over the blocks of every second column, from those of columns. Isa is the vocabulary of
// patch_boxes_body.h and more: of bytes with a sign as words, which are two columns side by side,
//   pairs(v), firsts(v), seconds(v)   8 times the sum of both; of the first one; of the second one
//   after<n>(a, b)                    words n .. of a, then those of b
// Blocks of 15 columns are those of 16 less one. kBlock: the block's width, 0 for any other than
// that.
template <typename Isa, std::size_t kBlock>
class QuarterBoxes {
 public:
  using Bytes = typename Isa::Bytes;
  using Sums = typename Isa::Sums;
  static constexpr std::size_t kBytes = Isa::kBytes;
  static constexpr std::size_t kSums = kBytes / 2;
  static constexpr std::size_t kOuts = (kQuarterColumns + kSums - 1) / kSums;  // vectors of sums
  static constexpr std::size_t kLine = kOuts * kSums;
  static constexpr std::size_t kMostParts = (kBlock != 0 ? 64 : 128) / kBytes;  // of columns
  static_assert(kPatchColumns + kBlock <= 64 + 1 || kBlock == 0);

  explicit QuarterBoxes(int block_width) noexcept
      : block_(static_cast<std::size_t>(block_width)),
        parts_((kPatchColumns + block_ - 1 + kBytes - 1) / kBytes) {}

  std::size_t parts() const noexcept { return kBlock != 0 ? kMostParts : parts_; }

  // Pairs of columns, and the one of each pair that a block of odd width splits off.
  struct Pairs {
    Sums both[kMostParts];
    Sums one[kMostParts];
    Pairs() noexcept {
      std::ranges::fill(both, Isa::all(0));
      std::ranges::fill(one, Isa::all(0));
    }
  };
  void add(const Bytes* columns, Pairs& pairs) const noexcept {
    for (std::size_t p = 0; p < parts(); ++p) {
      pairs.both[p] = Isa::add(pairs.both[p], Isa::pairs(columns[p]));
      if constexpr (kBlock == 15) {
        pairs.one[p] = Isa::add(pairs.one[p], Isa::seconds(columns[p]));
      } else if constexpr (kBlock == 0) {
        pairs.one[p] = Isa::add(pairs.one[p], Isa::firsts(columns[p]));
      }
    }
  }

  // boxes: kMostParts, of which the first kOuts are sums.
  void sum(const Pairs& pairs, Sums* boxes) const noexcept {
    if constexpr (kBlock == 0) {
      sum_any(pairs, boxes);
    } else {
      std::ranges::copy(pairs.both, boxes);
      fold<1>(boxes);
      fold<2>(boxes);
      fold<4>(boxes);
      for (std::size_t v = 0; kBlock == 15 && v < kOuts; ++v) {
        boxes[v] =
            Isa::subtract(boxes[v], Isa::template after<7>(pairs.one[v], next(pairs.one, v)));
      }
    }
  }
  // For columns below 64: two of them fit a byte.
  void sum_small(const Bytes* columns, Sums* boxes) const noexcept {
    if constexpr (kBlock == 0) {
      Pairs pairs;
      add(columns, pairs);
      sum_any(pairs, boxes);
    } else {
      for (std::size_t p = 0; p < kMostParts; ++p) {
        boxes[p] =
            Isa::pairs(Isa::plus(columns[p], Isa::template after<4>(columns[p], next(columns, p))));
      }
      fold<1>(boxes);
      fold<2>(boxes);
      for (std::size_t v = 0; kBlock == 15 && v < kOuts; ++v) {
        const Bytes last = Isa::template after<7>(columns[v], next(columns, v));
        boxes[v] = Isa::subtract(boxes[v], Isa::seconds(last));
      }
    }
  }

 private:
  // Columns behind the last vector are in no block.
  template <typename V>
  static V next(const V* v, std::size_t p) noexcept {
    return v[std::min(p + 1, kMostParts - 1)];
  }
  // Each and the one kBy words further.
  template <int kBy>
  static void fold(Sums* v) noexcept {
    for (std::size_t p = 0; p < kMostParts; ++p) {
      v[p] = Isa::add(v[p], Isa::template after<kBy>(v[p], next(v, p)));
    }
  }
  void sum_any(const Pairs& columns, Sums* boxes) const noexcept {
    alignas(64) std::uint16_t pairs[kMostParts * kSums + kLine];
    alignas(64) std::uint16_t firsts[kMostParts * kSums + kLine];
    for (std::size_t p = 0; p < parts(); ++p) {
      Isa::store(pairs + p * kSums, columns.both[p]);
      Isa::store(firsts + p * kSums, columns.one[p]);
    }
    for (std::size_t v = 0; v < kOuts; ++v) {
      boxes[v] = Isa::all(0);
      for (std::size_t k = 0; k < block_ / 2; ++k) {
        boxes[v] = Isa::add(boxes[v], Isa::load(pairs + v * kSums + k));
      }
      if (block_ % 2 != 0) {
        boxes[v] = Isa::add(boxes[v], Isa::load(firsts + v * kSums + block_ / 2));
      }
    }
  }

  std::size_t block_;
  std::size_t parts_;
};

}  // namespace stof::dsp::patch_quarter_body
