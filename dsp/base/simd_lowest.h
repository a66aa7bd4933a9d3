#pragma once

#include <bit>
#include <cstdint>

#include "dsp/base/simd.h"

// The lowest of many, for which other processors than ARM have an instruction of their own.
namespace stof::dsp::simd {

// The smallest lane in every lane. Other processors than ARM have one instruction for 16 bits.
inline uint8x16_t smallest_everywhere(uint8x16_t v) noexcept {
#if defined(__aarch64__)
  return vdupq_n_u8(vminvq_u8(v));
#else
  const __m128i bytes = std::bit_cast<__m128i>(v);
  const __m128i pairs = _mm_min_epu8(bytes, _mm_srli_epi16(bytes, 8));  // high bytes become 0
  return std::bit_cast<uint8x16_t>(_mm_shuffle_epi8(_mm_minpos_epu16(pairs), _mm_setzero_si128()));
#endif
}
inline uint16x8_t smallest_everywhere(uint16x8_t v) noexcept {
#if defined(__aarch64__)
  return vdupq_n_u16(vminvq_u16(v));
#else
  const __m128i least = _mm_minpos_epu16(std::bit_cast<__m128i>(v));
  return std::bit_cast<uint16x8_t>(_mm_shuffle_epi8(least, _mm_set1_epi16(0x0100)));
#endif
}
inline uint32x4_t smallest_everywhere(uint32x4_t v) noexcept { return vdupq_n_u32(vminvq_u32(v)); }

// The lowest element of each of eight vectors, and where it stands first.
inline void find_lowest(const std::uint16_t* eights, uint16x8_t& lowest,
                        uint16x8_t& where) noexcept {
#if defined(__SSE4_1__)
  __m128i found[8];  // the lowest and where, in the low 32 bits
  for (int k = 0; k < 8; ++k) {
    found[k] = _mm_minpos_epu16(std::bit_cast<__m128i>(vld1q_u16(eights + 8 * k)));
  }
  const __m128i low = _mm_unpacklo_epi64(_mm_unpacklo_epi32(found[0], found[1]),
                                         _mm_unpacklo_epi32(found[2], found[3]));
  const __m128i high = _mm_unpacklo_epi64(_mm_unpacklo_epi32(found[4], found[5]),
                                          _mm_unpacklo_epi32(found[6], found[7]));
  const __m128i mask = _mm_set1_epi32(0xFFFF);
  lowest = std::bit_cast<uint16x8_t>(
      _mm_packus_epi32(_mm_and_si128(low, mask), _mm_and_si128(high, mask)));
  where = std::bit_cast<uint16x8_t>(
      _mm_packus_epi32(_mm_srli_epi32(low, 16), _mm_srli_epi32(high, 16)));
#else
  uint16x8_t v[8];
  for (int k = 0; k < 8; ++k) {
    v[k] = vld1q_u16(eights + 8 * k);
  }
  const auto least_of_each = [](const uint16x8_t(&of)[8]) noexcept {
    const uint16x8_t low = vpminq_u16(vpminq_u16(of[0], of[1]), vpminq_u16(of[2], of[3]));
    const uint16x8_t high = vpminq_u16(vpminq_u16(of[4], of[5]), vpminq_u16(of[6], of[7]));
    return vpminq_u16(low, high);
  };
  lowest = least_of_each(v);
  const uint16x8_t number = {0, 1, 2, 3, 4, 5, 6, 7};
  v[0] = vornq_u16(number, vceqq_u16(v[0], vdupq_laneq_u16(lowest, 0)));
  v[1] = vornq_u16(number, vceqq_u16(v[1], vdupq_laneq_u16(lowest, 1)));
  v[2] = vornq_u16(number, vceqq_u16(v[2], vdupq_laneq_u16(lowest, 2)));
  v[3] = vornq_u16(number, vceqq_u16(v[3], vdupq_laneq_u16(lowest, 3)));
  v[4] = vornq_u16(number, vceqq_u16(v[4], vdupq_laneq_u16(lowest, 4)));
  v[5] = vornq_u16(number, vceqq_u16(v[5], vdupq_laneq_u16(lowest, 5)));
  v[6] = vornq_u16(number, vceqq_u16(v[6], vdupq_laneq_u16(lowest, 6)));
  v[7] = vornq_u16(number, vceqq_u16(v[7], vdupq_laneq_u16(lowest, 7)));
  where = least_of_each(v);
#endif
}

}  // namespace stof::dsp::simd
