#pragma once

#include <bit>
#include <cstdint>
#include <span>

#include "dsp/base/avx2.h"

// Reductions of costs, for *_avx2.cpp of dsp/stereo only.
namespace stof::dsp::avx2 {

// How many costs a vector holds; fewer go to NEON.
template <typename Sum>
inline constexpr int kLanesOf = static_cast<int>(32 / sizeof(Sum));

// The smallest lane in every lane.
static inline u8x32 lowest_everywhere(u8x32 v) noexcept {
  const __m256i all_lanes = bits(v);
  const __m128i half =
      _mm_min_epu8(_mm256_castsi256_si128(all_lanes), _mm256_extracti128_si256(all_lanes, 1));
  const __m128i pairs = _mm_min_epu8(half, _mm_srli_epi16(half, 8));  // high bytes become 0
  return as<u8x32>(_mm256_broadcastb_epi8(_mm_minpos_epu16(pairs)));
}
static inline u16x16 lowest_everywhere(u16x16 v) noexcept {
  const __m256i all_lanes = bits(v);
  const __m128i half =
      _mm_min_epu16(_mm256_castsi256_si128(all_lanes), _mm256_extracti128_si256(all_lanes, 1));
  return as<u16x16>(_mm256_broadcastw_epi16(_mm_minpos_epu16(half)));
}

// A bit for each lane.
static inline std::uint32_t mask_of(u8x32 mask) noexcept {
  return std::bit_cast<std::uint32_t>(_mm256_movemask_epi8(bits(mask)));
}

}  // namespace stof::dsp::avx2
