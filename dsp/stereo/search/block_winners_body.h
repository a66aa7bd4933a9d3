#pragma once

#include <cstring>

#include "dsp/base/check.h"
#include "dsp/base/mutation.h"
#include "dsp/stereo/search/block_strips_body.h"

// The pass over a row that the vector variants of block_winners() share. Isa is the
// vocabulary of one of them:
//   V, kLanes                      a vector of u16 sums
//   load, store, add, sub, smaller, either (bitwise or), without (a and not b), eighth (>> 3)
//   pixel(p)                       a left pixel in all lanes
//   Change, change(l, r, ol, or)   |l - r| and |ol - or| of 2 kLanes candidates
//   add_change(change, a, b)       a, b += 8 (|l - r| - |ol - or|)
//   exchange(l, r, ol, or, a)      of kLanes, where these are 16
//   numbers(v)                     what the groups of the v-th vector of 64 are numbered with
//   outside(first, begin, end)     all ones in lanes whose candidate, first + lane, is none of
//   these store_eight(p, v)              the lowest of each lane number modulo 8 store_parts(p, v)
//   the sums of each lane number modulo 8 add_parts(parts, first, totals)
//                                  what four columns have in eight parts, and had where first > 0
//   kColumns                       columns that are finished at once, by
//   lowest(eights, first, costs, winners)
//                                  winners among candidates from `first` on and, where first > 0,
//                                  those found before; returns whether one is 0
//   fit<kShift>(row, columns, places, costs, winners, kept, fitted)
//                                  the winners again and their fits; the sums of kColumns columns
//                                  begin at columns + places[k] each
namespace stof::dsp::block_winners_body {

// Above every cost, where sums have lost their three bits.
inline constexpr std::uint16_t kNone = kNoCost<std::uint16_t> >> 3;

template <typename Isa>
class Pass {
 public:
  Pass(const BlockPixels& pixels, const BlockRow& row, std::uint16_t* columns,
       const BlockMatches& out) noexcept
      : pixels_(pixels),
        row_(row),
        out_(out),
        columns_(columns),
        lanes_(static_cast<std::size_t>(row.lanes)),
        block_(static_cast<std::size_t>(row.block_width)) {}

  void go() noexcept {
    for_strips([&]<std::size_t kPairs>(std::size_t first) noexcept { begin<kPairs>(first); });
    for (std::size_t x = 0; x < out_.winners.size(); x += kChunk) {
      const std::size_t count = std::min(kChunk, out_.winners.size() - x);
      for_strips(
          [&]<std::size_t kPairs>(std::size_t first) noexcept { search<kPairs>(x, count, first); });
      finish(x, count);
    }
  }

 private:
  static constexpr std::size_t kMargin = kBlockCostMargin;

  // 64 candidates at a time keep their sums in registers; what is left is 32 or 16.
  template <typename Call>
  void for_strips(Call&& call) noexcept {
    constexpr std::size_t kPair = 2 * Isa::kLanes;
    std::size_t first = 0;
    for (; first + 64 <= lanes_; first += 64) {
      call.template operator()<64 / kPair>(first);
    }
    if constexpr (kPair <= 32) {
      if (first + 32 <= lanes_) {
        call.template operator()<32 / kPair>(first);
        first += 32;
      }
    }
    if constexpr (kPair <= 32) {
      if (first < lanes_) {
        call.template operator()<16 / kPair>(first);
      }
    }
  }

  bool keeps_costs() const noexcept { return !out_.costs.empty() && !out_.numbered; }
  // The sums of a chunk that are in memory.
  std::uint16_t* sums(std::size_t x) noexcept {
    return out_.costs.empty() ? ring_ + kMargin : out_.costs.data() + x * lanes_;
  }

  // The first block but for its last column.
  template <std::size_t kPairs>
  void begin(std::size_t first) noexcept {
    Strip<Isa, kPairs> strip;
    for (std::size_t v = 0; v < strip.kVectors; ++v) {
      strip.sums[v] = Isa::numbers(first % 64 / Isa::kLanes + v);
    }
    Place at(pixels_, columns_, lanes_, 0, first);
    for (std::size_t k = 0; k + 1 < block_; ++k, at.advance(lanes_)) {
      strip.exchange(at);
    }
    strip.store(state_ + first);
  }

  template <std::size_t kPairs>
  void search(std::size_t x, std::size_t count, std::size_t first) noexcept {
    whole(row_, x, count) ? run_kept<kPairs, false>(x, count, first)
                          : run_kept<kPairs, true>(x, count, first);
    chunk_.has_first = false;
    for (std::size_t p = 0; p < count; p += Isa::kColumns) {
      chunk_.has_first |= Isa::lowest(chunk_.eights.data() + 8 * p, first, chunk_.costs.data() + p,
                                      chunk_.winners.data() + p);
    }
    for (std::size_t p = 0; !out_.margins.empty() && p < count; p += 4) {
      Isa::add_parts(chunk_.parts.data() + 8 * p, first, chunk_.totals.data() + p);
    }
  }

  template <std::size_t kPairs, bool kMasked>
  void run_kept(std::size_t x, std::size_t count, std::size_t first) noexcept {
    if (!out_.margins.empty()) {
      keeps_costs() ? run<kPairs, kMasked, Keep::kCostsAndTotals>(x, count, first)
                    : run<kPairs, kMasked, Keep::kSumsAndTotals>(x, count, first);
    } else if (keeps_costs()) {
      run<kPairs, kMasked, Keep::kCosts>(x, count, first);
    } else {
      run<kPairs, kMasked, Keep::kSums>(x, count, first);
    }
  }

  template <std::size_t kPairs, bool kMasked, Keep kKeep>
  void run(std::size_t x, std::size_t count, std::size_t first) noexcept {
    // All in locals: the compiler must take vector stores for stores to members.
    const std::size_t lanes = lanes_;
    Place at(pixels_, columns_, lanes, x + block_ - 1, first);
    const std::uint16_t* leaving = columns_ + x * lanes + first;
    std::uint16_t* to = sums(x) + first;
    std::uint16_t* eights = chunk_.eights.data();
    std::uint16_t* parts = chunk_.parts.data();
    settle(leaving);
    settle(to);
    settle(eights);
    settle(parts);
    Strip<Isa, kPairs> strip;
    strip.load(state_ + first);
    for (std::size_t p = 0; p < count; ++p) {
      strip.exchange(at);
      const Limits exist = kMasked ? limits(row_, x + p) : Limits{};
      strip.template keep<kMasked, kKeep>(exist, static_cast<int>(first), to, eights, parts);
      strip.leave(leaving);
      at.advance(lanes);
      leaving += lanes;
      to += lanes;
      eights += 8;
      parts += 8;
    }
    strip.store(state_ + first);
  }

  void finish(std::size_t x, std::size_t count) noexcept;
  void drop_ties(std::size_t x, std::size_t count) noexcept;
  void find_margins(std::size_t x, std::size_t count) noexcept;
  using Places = std::array<std::uint16_t, Isa::kColumns>;
  template <int kShift>
  void fit(std::size_t x, std::size_t count) noexcept;

  BlockPixels pixels_;
  BlockRow row_;
  BlockMatches out_;
  std::uint16_t* columns_;
  std::size_t lanes_;
  std::size_t block_;
  alignas(64) std::uint16_t state_[kMostLanes];
  alignas(64) std::uint16_t ring_[kChunk * kMostLanes + 2 * kMargin];
  Chunk chunk_{};
};

}  // namespace stof::dsp::block_winners_body
