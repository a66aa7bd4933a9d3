#pragma once

#include <cstddef>
#include <cstdint>

#include "dsp/base/avx2.h"
#include "dsp/stereo/refine/subpixel.h"

// What block_eights_avx2.h is made of: sixteen words at once.
namespace stof::dsp::avx2 {

template <typename Isa>
struct BlockVectors {  // NOLINT(bugprone-crtp-constructor-accessibility): functions alone
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
