#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <limits>

#include "lab/pyramid/patch_sums.h"

// The common part of the NEON and the AVX2 variant of patch_sums.h. Isa is the vocabulary of one of
// them:
//   kBytes                     bytes of a vector; kBytes / 2 sums
//   load_bytes, store_bytes, difference (|a - b|), plus, minus      of bytes
//   load, store, all, add, smaller, times8, eighth, low_bits, less, equal, both, either, select
//                              of sums; any: whether a mask has a lane
//   between(begin, end)        the lanes begin .. end - 1
//   widen, low, high           half a vector of bytes as sums: with a sign; without one
//   sixteens(p, low, high)     8 (p[x] + p[x + 1] + p[x + 8] + p[x + 9]) with a sign, of kBytes x
namespace stof::dsp::patch_sums_body {

inline constexpr std::size_t kColumns = kPatchColumns;
inline constexpr std::size_t kGroup = kPatchSumScale;  // candidates that are worked on together
// The longest row of a patch, and what the last vectors reach beyond it.
inline constexpr std::size_t kLine = static_cast<std::size_t>(patch_reach(64)) + 32;

// kBlock: the block's width, 0 for any other than that.
template <typename Isa, std::size_t kBlock>
class Boxes {
 public:
  using Bytes = typename Isa::Bytes;
  using Sums = typename Isa::Sums;
  static constexpr std::size_t kBytes = Isa::kBytes;
  static constexpr std::size_t kSums = kBytes / 2;

  explicit Boxes(const PatchPlace& patch) noexcept
      : patch_(patch), any_block_(static_cast<std::size_t>(patch.block_width)) {}

  // sums += what rows differ by along `entering` less that of `leaving`.
  void slide(int entering, int leaving, std::size_t first, std::size_t count,
             std::uint16_t* sums) noexcept;  // patch_sums_body.h

  void start(Rows rows, std::size_t first, std::size_t count, std::uint16_t* sums) noexcept {
    for (std::size_t i = 0; i < count; ++i) {
      for (std::size_t k = 0; k < columns(); k += kBytes) {
        total(rows, k, right_at(first + i), totals_[i] + k);
      }
    }
    for (std::size_t i = 0; i < count; ++i) {
      const auto one = [&](std::size_t x) noexcept { return Isa::load(totals_[i] + x); };
      const auto four = [&](std::size_t x) noexcept {
        return Isa::add(Isa::add(one(x), one(x + 1)), Isa::add(one(x + 2), one(x + 3)));
      };
      std::fill_n(sums + i * kColumns, kColumns, static_cast<std::uint16_t>(i));
      add_boxes(four, one, sums + i * kColumns);
    }
  }

 private:
  std::size_t block() const noexcept { return kBlock == 0 ? any_block_ : kBlock; }
  std::size_t columns() const noexcept {
    const std::size_t reached = kColumns + (kSixteens ? 16 : block()) - 1;
    return (reached + kBytes - 1) / kBytes * kBytes;
  }
  std::ptrdiff_t right_at(std::size_t place) const noexcept {
    return patch_.right_x - patch_.candidates[place];
  }

  // Sums the differences of a vector's columns over all rows.
  void total(Rows rows, std::size_t k, std::ptrdiff_t right, std::uint16_t* to) const noexcept {
    constexpr int kRows = std::numeric_limits<std::uint8_t>::max() / kLargestPatchPixel;
    const auto difference_at = [&](int y) noexcept {
      return Isa::difference(Isa::load_bytes(patch_.left.row_clamped(y).data() + patch_.left_x + k),
                             Isa::load_bytes(patch_.right.row_clamped(y).data() + right +
                                             static_cast<std::ptrdiff_t>(k)));
    };
    Sums low = Isa::all(0);
    Sums high = low;
    for (int y = rows.begin; y < rows.end;) {
      const int stop = std::min(y + kRows, rows.end);
      Bytes sum = difference_at(y);
      for (++y; y < stop; ++y) {
        sum = Isa::plus(sum, difference_at(y));
      }
      low = Isa::add(low, Isa::low(sum));
      high = Isa::add(high, Isa::high(sum));
    }
    Isa::store(to, low);
    Isa::store(to + kSums, high);
  }

  // Sums over the block's columns, from those of four columns and of one.
  template <typename Four, typename One>
  void add_boxes(Four four, One one, std::uint16_t* sums) const noexcept {
    const std::size_t by_fours = block() / 4 * 4;
    for (std::size_t x = 0; x < kColumns; x += kSums) {
      Sums sum = by_fours > 0 ? four(x) : one(x);
      for (std::size_t k = 4; k < by_fours; k += 4) {
        sum = Isa::add(sum, four(x + k));
      }
      for (std::size_t k = std::max<std::size_t>(by_fours, 1); k < block(); ++k) {
        sum = Isa::add(sum, one(x + k));
      }
      Isa::store(sums + x, Isa::add(Isa::load(sums + x), Isa::times8(sum)));
    }
  }

  // Every second column: four and the four beside them are eight columns.
  void add_sixteens(std::size_t i, std::uint16_t* sums) const noexcept {
    const auto add = [&](std::size_t x, Sums change) noexcept {
      if constexpr (kBlock == 15) {
        change = Isa::subtract(change, Isa::times8(Isa::widen(ones_[i] + x + kBlock)));
      }
      Isa::store(sums + x, Isa::add(Isa::load(sums + x), change));
    };
    for (std::size_t x = 0; x < kColumns; x += kBytes) {
      Sums low;
      Sums high;
      Isa::sixteens(fours_[i] + x, low, high);
      add(x, low);
      if (x + kSums < kColumns) {
        add(x + kSums, high);
      }
    }
  }

  // Blocks of 16 columns, and of 15 as these less one.
  static constexpr bool kSixteens = kBlock == 15 || kBlock == 16;
  static constexpr std::size_t kStride = kSixteens ? 2 : 1;  // between the columns of a four

  const PatchPlace& patch_;
  std::size_t any_block_;
  alignas(32) std::uint8_t ones_[kGroup][kLine];   // changes of columns
  alignas(32) std::uint8_t fours_[kGroup][kLine];  // of four columns, kStride apart
  alignas(32) std::uint16_t totals_[kGroup][kLine];
};

}  // namespace stof::dsp::patch_sums_body
