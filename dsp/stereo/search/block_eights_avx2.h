#pragma once

#include <cstddef>
#include <cstdint>

#include "dsp/base/avx2.h"
#include "dsp/stereo/search/block_winners.h"

// Winners and fits of eight columns, for the AVX2 and AVX-512 variants of block_winners(): a
// template, so that each has its own. See block_winners_body.h.
namespace stof::dsp::avx2 {

template <typename Isa>
struct Eights {  // NOLINT(bugprone-crtp-constructor-accessibility): functions alone
  static void lowest(const std::uint16_t* eights, std::size_t first, std::uint16_t* costs,
                     std::int16_t* winners) noexcept {
    __m128i found[8];  // the lowest and where, in the low 32 bits
    for (int k = 0; k < 8; ++k) {
      found[k] = _mm_minpos_epu16(get(eights + 8 * k));
    }
    const __m128i low = _mm_unpacklo_epi64(_mm_unpacklo_epi32(found[0], found[1]),
                                           _mm_unpacklo_epi32(found[2], found[3]));
    const __m128i high = _mm_unpacklo_epi64(_mm_unpacklo_epi32(found[4], found[5]),
                                            _mm_unpacklo_epi32(found[6], found[7]));
    const __m128i mask = _mm_set1_epi32(0xFFFF);
    const __m128i sums = _mm_packus_epi32(_mm_and_si128(low, mask), _mm_and_si128(high, mask));
    const __m128i lane = _mm_packus_epi32(_mm_srli_epi32(low, 16), _mm_srli_epi32(high, 16));
    const __m128i group = _mm_slli_epi16(_mm_and_si128(sums, _mm_set1_epi16(7)), 3);
    const __m128i winner =
        _mm_add_epi16(_mm_add_epi16(group, lane), _mm_set1_epi16(static_cast<std::int16_t>(first)));
    const __m128i cost = _mm_srli_epi16(sums, 3);  // below 2^15: signed comparisons will do
    if (first == 0) {
      put(costs, cost);
      put(winners, winner);
      return;
    }
    const __m128i before = get(costs);
    const __m128i better = _mm_cmpgt_epi16(before, cost);
    put(costs, _mm_min_epu16(cost, before));
    put(winners, _mm_blendv_epi8(get(winners), winner, better));
  }

  // around[k]: the sums of the candidates before and behind the k-th winner, and its own between.
  template <int kShift>
  static void fit(const BlockRow& row, const std::uint16_t* const (&around)[8],
                  const std::uint16_t* costs, const std::int16_t* winners,
                  std::int16_t* fitted) noexcept {
    const __m128i winner = get(winners);
    const __m128i base =
        _mm_add_epi16(winner, _mm_set1_epi16(static_cast<std::int16_t>(row.min_disparity)));
    __m128i out = _mm_slli_epi16(base, Disparity::kFractionBits);
    if (row.fit != CostFit::kNone) {
      __m128i before;
      __m128i after;
      gather(around, before, after);
      // Where none are missing, costs are below 2^15.
      const __m128i missing = _mm_cmpeq_epi16(_mm_max_epu16(before, after), _mm_set1_epi16(-1));
      before = _mm_srli_epi16(before, kShift);
      after = _mm_srli_epi16(after, kShift);
      const __m128i last = _mm_set1_epi16(static_cast<std::int16_t>(row.lanes - 1));
      const __m128i inside = _mm_and_si128(_mm_cmpgt_epi16(winner, _mm_setzero_si128()),
                                           _mm_cmpgt_epi16(last, winner));
      const __m128i usable = _mm_andnot_si128(missing, inside);
      const __m128i shift = _mm_and_si128(sixteenths(before, get(costs), after, row.fit), usable);
      // Minus where the candidate before is the cheaper one; 0 stays where they are equal.
      out = _mm_add_epi16(out, _mm_sign_epi16(shift, _mm_sub_epi16(before, after)));
    }
    const __m128i none = _mm_cmpeq_epi16(winner, _mm_set1_epi16(kNoWinner));
    put(fitted, _mm_blendv_epi8(out, _mm_set1_epi16(Disparity::none().raw), none));
  }

 protected:
  template <typename Lane>
  static __m128i get(const Lane* p) noexcept {
    return _mm_loadu_si128(reinterpret_cast<const __m128i*>(p));  // NOLINT: any type
  }
  template <typename Lane>
  static void put(Lane* p, __m128i v) noexcept {
    store_bits(p, v);
    unmutate(p);
  }

  // Elements 0 and 2 of each.
  static void gather(const std::uint16_t* const (&around)[8], __m128i& before,
                     __m128i& after) noexcept {
    __m128i four[8];
    for (int k = 0; k < 8; ++k) {
      four[k] = _mm_loadl_epi64(reinterpret_cast<const __m128i*>(around[k]));  // NOLINT: any type
    }
    // Element by element: 0 0 1 1 2 2 3 3 of two pixels, then of four, then of eight.
    const __m128i a = _mm_unpacklo_epi16(four[0], four[1]);
    const __m128i b = _mm_unpacklo_epi16(four[2], four[3]);
    const __m128i c = _mm_unpacklo_epi16(four[4], four[5]);
    const __m128i d = _mm_unpacklo_epi16(four[6], four[7]);
    before = _mm_unpacklo_epi64(_mm_unpacklo_epi32(a, b), _mm_unpacklo_epi32(c, d));
    after = _mm_unpacklo_epi64(_mm_unpackhi_epi32(a, b), _mm_unpackhi_epi32(c, d));
  }

  // 0..8: 16 |before - after| reaches (2 k - 1) rises for k = 1.. once for each of them, which is
  // when 8 |before - after| + rise / 2 reaches k rises.
  static __m128i sixteenths(__m128i before, __m128i best, __m128i after, CostFit fit) noexcept {
    const __m128i higher = _mm_sub_epi16(_mm_max_epu16(before, after), best);
    const __m128i lower = _mm_sub_epi16(_mm_min_epu16(before, after), best);
    const __m128i rise = fit == CostFit::kEquiangular ? higher : _mm_adds_epu16(higher, lower);
    const __m128i reach =
        _mm_add_epi16(_mm_slli_epi16(_mm_sub_epi16(higher, lower), 3), _mm_srli_epi16(rise, 1));
    __m128i bound = rise;
    __m128i count = _mm_setzero_si128();
    for (int k = 0; k < 8; ++k) {
      const __m128i reached = _mm_cmpeq_epi16(_mm_max_epu16(reach, bound), reach);
      count = _mm_sub_epi16(count, reached);  // a true mask is -1
      bound = _mm_adds_epu16(bound, rise);
    }
    return _mm_andnot_si128(_mm_cmpeq_epi16(rise, _mm_setzero_si128()), count);
  }
};

}  // namespace stof::dsp::avx2
