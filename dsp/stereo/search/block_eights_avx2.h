#pragma once

#include <cstddef>
#include <cstdint>

#include "dsp/base/avx2.h"
#include "dsp/stereo/search/block_winners.h"

// Winners and fits of sixteen columns, for the AVX2 and AVX-512 variants of block_winners(): a
// template, so that each has its own. See block_winners_body.h.
namespace stof::dsp::avx2 {

template <typename Isa>
struct Eights {  // NOLINT(bugprone-crtp-constructor-accessibility): functions alone
  static constexpr std::size_t kColumns = 16;

  static bool lowest(const std::uint16_t* eights, std::size_t first, std::uint16_t* costs,
                     std::int16_t* winners) noexcept {
    const Found found = lowest_of_each(eights, eights + 64);
    const __m256i group = _mm256_slli_epi16(_mm256_and_si256(found.sums, words(7)), 3);
    __m256i winner = _mm256_add_epi16(_mm256_add_epi16(group, found.lanes),
                                      words(static_cast<std::int16_t>(first)));
    __m256i cost = _mm256_srli_epi16(found.sums, 3);  // below 2^15: signed comparisons will do
    if (first != 0) {
      const __m256i before = get(costs);
      const __m256i better = _mm256_cmpgt_epi16(before, cost);
      cost = _mm256_min_epu16(cost, before);
      winner = _mm256_blendv_epi8(get(winners), winner, better);
    }
    put(costs, cost);
    put(winners, winner);
    return _mm256_movemask_epi8(_mm256_cmpgt_epi16(words(1), winner)) != 0;
  }

  // Parts less 32768, which products add up in pairs.
  static void add_parts(const std::uint16_t* parts, std::size_t first,
                        std::uint32_t* totals) noexcept {
    const auto pairs = [&](int k) noexcept {
      return _mm_madd_epi16(_mm_xor_si128(get_half(parts + 8 * k), _mm_set1_epi16(-32768)),
                            _mm_set1_epi16(1));
    };
    __m128i sums =
        _mm_hadd_epi32(_mm_hadd_epi32(pairs(0), pairs(1)), _mm_hadd_epi32(pairs(2), pairs(3)));
    sums = _mm_add_epi32(sums, _mm_set1_epi32(8 * 32768));
    put(totals, first == 0 ? sums : _mm_add_epi32(sums, get_half(totals)));
  }

  template <int kShift>
  static void fit(const BlockRow& row, const std::uint16_t* const (&around)[kColumns],
                  const std::uint16_t* costs, const std::int16_t* winners, std::int16_t* kept,
                  std::int16_t* fitted) noexcept {
    const __m256i winner = get(winners);
    const __m256i base =
        _mm256_add_epi16(winner, words(static_cast<std::int16_t>(row.min_disparity)));
    __m256i out = _mm256_slli_epi16(base, Disparity::kFractionBits);
    if (row.fit != CostFit::kNone) {
      const Around low = gather(around);
      const Around high = gather(around + 8);
      __m256i before = _mm256_set_m128i(high.before, low.before);
      __m256i after = _mm256_set_m128i(high.after, low.after);
      // Where none are missing, costs are below 2^15.
      const __m256i missing = _mm256_cmpeq_epi16(_mm256_max_epu16(before, after), words(-1));
      before = _mm256_srli_epi16(before, kShift);
      after = _mm256_srli_epi16(after, kShift);
      const __m256i last = words(static_cast<std::int16_t>(row.lanes - 1));
      const __m256i inside = _mm256_and_si256(_mm256_cmpgt_epi16(winner, _mm256_setzero_si256()),
                                              _mm256_cmpgt_epi16(last, winner));
      const __m256i usable = _mm256_andnot_si256(missing, inside);
      const __m256i shift =
          _mm256_and_si256(sixteenths(before, get(costs), after, row.fit), usable);
      // Minus where the candidate before is the cheaper one; 0 stays where they are equal.
      out = _mm256_add_epi16(out, _mm256_sign_epi16(shift, _mm256_sub_epi16(before, after)));
    }
    const __m256i none = _mm256_cmpeq_epi16(winner, words(kNoWinner));
    put(kept, winner);
    put(fitted, _mm256_blendv_epi8(out, words(Disparity::none().raw), none));
  }

 protected:
  static __m256i words(std::int16_t v) noexcept { return _mm256_set1_epi16(v); }
  template <typename Lane>
  static __m256i get(const Lane* p) noexcept {
    return _mm256_loadu_si256(reinterpret_cast<const __m256i*>(p));  // NOLINT: any type
  }
  template <typename Lane>
  static __m128i get_half(const Lane* p) noexcept {
    return _mm_loadu_si128(reinterpret_cast<const __m128i*>(p));  // NOLINT: any type
  }
  template <typename Lane>
  static void put(Lane* p, __m256i v) noexcept {
    store(reinterpret_cast<std::int16_t*>(p), as<i16x16>(v));  // NOLINT: one of either sign
    unmutate(p);
  }
  template <typename Lane>
  static void put(Lane* p, __m128i v) noexcept {
    store_bits(p, v);
    unmutate(p);
  }

  struct Found {
    __m256i sums;
    __m256i lanes;
  };
  // The lowest of each eight, and where, of eights from either place on.
  static Found lowest_of_each(const std::uint16_t* low, const std::uint16_t* high) noexcept {
    __m256i found[8];  // the lowest and where, in the low 32 bits of both halves
    for (int k = 0; k < 8; ++k) {
      found[k] = _mm256_set_m128i(_mm_minpos_epu16(get_half(high + 8 * k)),
                                  _mm_minpos_epu16(get_half(low + 8 * k)));
    }
    const __m256i a = _mm256_unpacklo_epi64(_mm256_unpacklo_epi32(found[0], found[1]),
                                            _mm256_unpacklo_epi32(found[2], found[3]));
    const __m256i b = _mm256_unpacklo_epi64(_mm256_unpacklo_epi32(found[4], found[5]),
                                            _mm256_unpacklo_epi32(found[6], found[7]));
    const __m256i mask = _mm256_set1_epi32(0xFFFF);
    return {_mm256_packus_epi32(_mm256_and_si256(a, mask), _mm256_and_si256(b, mask)),
            _mm256_packus_epi32(_mm256_srli_epi32(a, 16), _mm256_srli_epi32(b, 16))};
  }

  struct Around {
    __m128i before;
    __m128i after;
  };
  // Elements 0 and 2 of eight.
  static Around gather(const std::uint16_t* const* around) noexcept {
    __m128i four[8];
    for (int k = 0; k < 8; ++k) {
      four[k] = _mm_loadl_epi64(reinterpret_cast<const __m128i*>(around[k]));  // NOLINT: any type
    }
    // Element by element: 0 0 1 1 2 2 3 3 of two pixels, then of four, then of eight.
    const __m128i a = _mm_unpacklo_epi16(four[0], four[1]);
    const __m128i b = _mm_unpacklo_epi16(four[2], four[3]);
    const __m128i c = _mm_unpacklo_epi16(four[4], four[5]);
    const __m128i d = _mm_unpacklo_epi16(four[6], four[7]);
    return {_mm_unpacklo_epi64(_mm_unpacklo_epi32(a, b), _mm_unpacklo_epi32(c, d)),
            _mm_unpacklo_epi64(_mm_unpackhi_epi32(a, b), _mm_unpackhi_epi32(c, d))};
  }

  // 0..8: how often `rise` goes into 8 |before - after| + rise / 2, as (16 |before - after| + rise)
  // / (2 rise). A quotient that is no whole number lies 2^-15 from one at least, which floats tell.
  static __m256i sixteenths(__m256i before, __m256i best, __m256i after, CostFit fit) noexcept {
    const __m256i higher = _mm256_sub_epi16(_mm256_max_epu16(before, after), best);
    const __m256i lower = _mm256_sub_epi16(_mm256_min_epu16(before, after), best);
    const __m256i rise = fit == CostFit::kEquiangular ? higher : _mm256_add_epi16(higher, lower);
    const __m256i reach = _mm256_add_epi16(_mm256_slli_epi16(_mm256_sub_epi16(higher, lower), 3),
                                           _mm256_srli_epi16(rise, 1));
    const __m256i zero = _mm256_setzero_si256();
    const auto times = [](__m256i of, __m256i in) noexcept {
      return _mm256_cvttps_epi32(_mm256_div_ps(_mm256_cvtepi32_ps(in), _mm256_cvtepi32_ps(of)));
    };
    const __m256i count = _mm256_packs_epi32(
        times(_mm256_unpacklo_epi16(rise, zero), _mm256_unpacklo_epi16(reach, zero)),
        times(_mm256_unpackhi_epi16(rise, zero), _mm256_unpackhi_epi16(reach, zero)));
    return _mm256_andnot_si256(_mm256_cmpeq_epi16(rise, zero), count);
  }
};

}  // namespace stof::dsp::avx2
