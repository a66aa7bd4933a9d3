#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>

#include "dsp/stereo/search/block_winners.h"

// The search of block_winners(), which its vector variants share. Isa: see
// block_winners_body.h.
namespace stof::dsp::block_winners_body {

// Columns that are searched before their winners are fitted: so many sums stay in L1.
inline constexpr std::size_t kChunk = 32;
inline constexpr std::size_t kMostLanes = 256;

struct alignas(64) Chunk {
  std::array<std::uint16_t, kChunk * 8> eights;  // lowest sums by lane number modulo 8
  std::array<std::uint16_t, kChunk * 8> parts;   // of totals, of 64 candidates at most
  std::array<std::uint32_t, kChunk> totals;      // of the costs of all candidates
  std::array<std::uint16_t, kChunk> costs;       // of the winners
  std::array<std::int16_t, kChunk> winners;
  bool has_first;  // a winner is candidate 0
};

// What becomes of the sums: they stay as they are, or become costs; the costs are added up too.
enum class Keep : std::uint8_t { kSums, kCosts, kSumsAndTotals, kCostsAndTotals };
constexpr bool keeps_sums(Keep kept) noexcept {
  return kept == Keep::kSums || kept == Keep::kSumsAndTotals;
}
constexpr bool counts_totals(Keep kept) noexcept { return kept >= Keep::kSumsAndTotals; }

// Candidates begin .. end - 1 exist.
struct Limits {
  int begin = 0;
  int end = 0;
};
inline Limits limits(const BlockRow& row, std::size_t x) noexcept {
  const int farthest = row.x + static_cast<int>(x) - row.min_disparity;
  return {std::max(farthest - row.right_width + 1, 0), std::min(row.disparities, farthest + 1)};
}
// Whether all columns of a chunk have all candidates, and no lane is unused.
inline bool whole(const BlockRow& row, std::size_t x, std::size_t count) noexcept {
  const Limits first = limits(row, x);
  const Limits last = limits(row, x + count - 1);
  return first.begin == 0 && last.begin == 0 && first.end == row.lanes && last.end == row.lanes;
}

// Makes an address one that compilers do not put together anew for each column.
template <typename T>
inline void settle(T*& address) noexcept {
  asm("" : "+r"(address));  // NOLINT(hicpp-no-assembler): no instruction
}

// Where the pixels and the sums of a column lie, from one candidate on.
struct Place {
  const std::uint8_t* new_left;
  const std::uint8_t* old_left;
  const std::uint8_t* new_right;
  const std::uint8_t* old_right;
  std::uint16_t* column;

  Place(const BlockPixels& pixels, std::uint16_t* columns, std::size_t lanes, std::size_t k,
        std::size_t first) noexcept
      : new_left(pixels.new_left.data() + k),
        old_left(pixels.old_left.data() + k),
        new_right(pixels.new_right.data() + (pixels.new_left.size() - 1 - k + first)),
        old_right(pixels.old_right.data() + (pixels.new_left.size() - 1 - k + first)),
        column(columns + k * lanes + first) {
    settle(new_left);
    settle(old_left);
    settle(new_right);
    settle(old_right);
    settle(column);
  }

  void advance(std::size_t lanes) noexcept {
    ++new_left;
    ++old_left;
    --new_right;
    --old_right;
    column += lanes;
  }
};

// 2 kPairs vectors of candidates, one where kPairs is 0, whose sums stay in registers.
template <typename Isa, std::size_t kPairs>
struct Strip {
  static_assert((kPairs & (kPairs - 1)) == 0);
  using V = typename Isa::V;
  static constexpr std::size_t kVectors = kPairs == 0 ? 1 : 2 * kPairs;
  static constexpr std::size_t kPair = 2 * Isa::kLanes;  // candidates that exchange at once

  V sums[kVectors];

  void load(const std::uint16_t* from) noexcept {
    for (std::size_t v = 0; v < kVectors; ++v) {
      sums[v] = Isa::load(from + v * Isa::kLanes);
    }
  }
  void store(std::uint16_t* to) const noexcept {
    for (std::size_t v = 0; v < kVectors; ++v) {
      Isa::store(to + v * Isa::kLanes, sums[v]);
    }
  }

  // One row of pixels enters the column sums of a column, one leaves them, and the block's sums
  // get them.
  void exchange(const Place& at) noexcept {
    const auto in = Isa::pixel(at.new_left);
    const auto gone = Isa::pixel(at.old_left);
    if constexpr (kPairs == 0) {
      V a = Isa::load(at.column);
      Isa::exchange(in, at.new_right, gone, at.old_right, a);
      Isa::store(at.column, a);
      sums[0] = Isa::add(sums[0], a);
    }
    // All pixels first: they could lie where sums are stored, as far as compilers know.
    typename Isa::Change changes[std::max<std::size_t>(kPairs, 1)];
    for (std::size_t q = 0; q < kPairs; ++q) {
      changes[q] = Isa::change(in, at.new_right + q * kPair, gone, at.old_right + q * kPair);
    }
    for (std::size_t q = 0; q < kPairs; ++q) {
      std::uint16_t* const column = at.column + q * kPair;
      V a = Isa::load(column);
      V b = Isa::load(column + Isa::kLanes);
      Isa::add_change(changes[q], a, b);
      Isa::store(column, a);
      Isa::store(column + Isa::kLanes, b);
      sums[2 * q] = Isa::add(sums[2 * q], a);
      sums[2 * q + 1] = Isa::add(sums[2 * q + 1], b);
    }
  }

  // Sums of candidates that exist go to memory, as costs or as they are, the lowest of each lane
  // number modulo 8 to `eights`, the costs' totals likewise to `parts`.
  template <bool kMasked, Keep kKeep>
  void keep(Limits exist, int first, std::uint16_t* to, std::uint16_t* eights,
            std::uint16_t* parts) const noexcept {
    V kept[kVectors];
    V counted[kVectors];
    for (std::size_t v = 0; v < kVectors; ++v) {
      kept[v] = sums[v];
      counted[v] = kKeep == Keep::kSums ? sums[v] : Isa::eighth(sums[v]);
      const V wanted = keeps_sums(kKeep) ? sums[v] : counted[v];
      if constexpr (kMasked) {
        const int candidate = first + static_cast<int>(v * Isa::kLanes);
        const V outside = Isa::outside(candidate, exist.begin, exist.end);
        kept[v] = Isa::either(kept[v], outside);
        counted[v] = Isa::without(counted[v], outside);
        Isa::store(to + v * Isa::kLanes, Isa::either(wanted, outside));
      } else {
        Isa::store(to + v * Isa::kLanes, wanted);
      }
    }
    for (std::size_t n = kPairs; n > 0; n /= 2) {  // a tree: nothing waits for long
      for (std::size_t v = 0; v < n; ++v) {
        kept[v] = Isa::smaller(kept[v], kept[v + n]);
        counted[v] = Isa::add(counted[v], counted[v + n]);
      }
    }
    Isa::store_eight(eights, kept[0]);
    if constexpr (counts_totals(kKeep)) {
      Isa::store_parts(parts, counted[0]);
    }
  }

  // A column leaves the block.
  void leave(const std::uint16_t* column) noexcept {
    for (std::size_t v = 0; v < kVectors; ++v) {
      sums[v] = Isa::sub(sums[v], Isa::load(column + v * Isa::kLanes));
    }
  }
};

}  // namespace stof::dsp::block_winners_body
