#pragma once

#include <cstddef>
#include <cstdint>

#include "dsp/base/avx2.h"
#include "dsp/base/fixed.h"
#include "dsp/fusion/resolve/ambiguity_resolver.h"

// What the AVX2 kernels that mark pixels of a fused row have in common.
namespace stof::dsp::avx2 {

inline constexpr std::size_t kMaskLanes = 32;
inline constexpr std::size_t kMaskWord = 64;

template <typename Value>
inline u8x32 equals(u8x32 values, Value value) noexcept {
  return as<u8x32>(_mm256_cmpeq_epi8(bits(values), bits(all(static_cast<std::uint8_t>(value)))));
}

// Of masks of 16 bits, in order.
inline u8x32 narrowed(__m256i first, __m256i second) noexcept {
  return as<u8x32>(_mm256_permute4x64_epi64(_mm256_packs_epi16(first, second), 0xD8));
}

// Not length > low / 12, the quotient rounded down: low * 43691 / 2^19 for every u16.
inline __m256i is_narrow(__m256i from, __m256i length) noexcept {
  static_assert(kNarrowShare == 12);
  const __m256i twelfth = bits(all(std::uint16_t{43691}));
  const __m256i share = _mm256_srli_epi16(_mm256_mulhi_epu16(from, twelfth), 3);
  // Not above: length less share saturates to 0.
  return _mm256_cmpeq_epi16(_mm256_subs_epu16(length, share), _mm256_setzero_si256());
}

inline u8x32 missing(const Disparity* disparity) noexcept {
  const __m256i none = bits(all(Disparity::none().raw));
  return narrowed(_mm256_cmpeq_epi16(bits(load<i16x16>(&disparity->raw)), none),
                  _mm256_cmpeq_epi16(bits(load<i16x16>(&disparity[16].raw)), none));
}

inline std::uint64_t mask(u8x32 v) noexcept {
  return static_cast<std::uint32_t>(_mm256_movemask_epi8(bits(v)));
}

inline void store_word(std::uint64_t first, std::uint64_t second, std::uint64_t* word) noexcept {
  *word = first | (second << kMaskLanes);
  mutate(word);
}

}  // namespace stof::dsp::avx2
