#pragma once

#include <bit>
#include <cstddef>
#include <cstdint>

#include <immintrin.h>

#include "dsp/base/mutation.h"

// The vocabulary of *_avx2.cpp files, which alone are compiled for AVX2. Nothing in here may be
// used by other files: what the linker took from an *_avx2.cpp would not run on older processors.
namespace stof::dsp::avx2 {

// 256 bits with a type for each kind of lane: + - * & | ^ ~ << >> == < work lane by lane, a true
// mask is -1, `mask ? a : b` selects.
template <typename Lane>
struct VectorOf {
  using type [[gnu::vector_size(32)]] = Lane;
};
using u8x32 = VectorOf<std::uint8_t>::type;
using u16x16 = VectorOf<std::uint16_t>::type;
using u32x8 = VectorOf<std::uint32_t>::type;
using i8x32 = VectorOf<std::int8_t>::type;
using i16x16 = VectorOf<std::int16_t>::type;
using i32x8 = VectorOf<std::int32_t>::type;

// Between them and the processor's own type.
template <typename V>
inline V as(__m256i v) noexcept {
  return std::bit_cast<V>(v);
}
template <typename V>
inline __m256i bits(V v) noexcept {
  return std::bit_cast<__m256i>(v);
}

// Any alignment.
template <typename V, typename Lane>
inline V load(const Lane* p) noexcept {
  return as<V>(_mm256_loadu_si256(reinterpret_cast<const __m256i*>(p)));  // NOLINT: any type
}
template <typename V, typename Lane>
inline void store(Lane* p, V v) noexcept {
  _mm256_storeu_si256(reinterpret_cast<__m256i*>(p), bits(v));  // NOLINT: any type
  mutate(p);
}

// The lower half.
template <typename V, typename Lane>
inline void store_half(Lane* p, V v) noexcept {
  _mm_storeu_si128(reinterpret_cast<__m128i*>(p),
                   _mm256_castsi256_si128(bits(v)));  // NOLINT: any type
  mutate(p);
}

// Vectors of other widths.
template <typename Lane>
inline void store_bits(Lane* p, __m128i v) noexcept {
  _mm_storeu_si128(reinterpret_cast<__m128i*>(p), v);  // NOLINT: any type
  mutate(p);
}
#if defined(__AVX512F__)
template <typename Lane>
inline void store_bits(Lane* p, __m512i v) noexcept {
  _mm512_storeu_si512(p, v);
  mutate(p);
}
#endif

inline u8x32 all(std::uint8_t v) noexcept {
  return as<u8x32>(_mm256_set1_epi8(std::bit_cast<char>(v)));
}
inline u16x16 all(std::uint16_t v) noexcept {
  return as<u16x16>(_mm256_set1_epi16(std::bit_cast<std::int16_t>(v)));
}
inline i16x16 all(std::int16_t v) noexcept { return as<i16x16>(_mm256_set1_epi16(v)); }
inline u32x8 all(std::uint32_t v) noexcept {
  return as<u32x8>(_mm256_set1_epi32(std::bit_cast<std::int32_t>(v)));
}
inline i32x8 all(std::int32_t v) noexcept { return as<i32x8>(_mm256_set1_epi32(v)); }

inline u8x32 smaller(u8x32 a, u8x32 b) noexcept {
  return as<u8x32>(_mm256_min_epu8(bits(a), bits(b)));
}
inline u16x16 smaller(u16x16 a, u16x16 b) noexcept {
  return as<u16x16>(_mm256_min_epu16(bits(a), bits(b)));
}
inline i16x16 smaller(i16x16 a, i16x16 b) noexcept {
  return as<i16x16>(_mm256_min_epi16(bits(a), bits(b)));
}
inline u32x8 smaller(u32x8 a, u32x8 b) noexcept {
  return as<u32x8>(_mm256_min_epu32(bits(a), bits(b)));
}
inline u8x32 larger(u8x32 a, u8x32 b) noexcept {
  return as<u8x32>(_mm256_max_epu8(bits(a), bits(b)));
}
inline u16x16 larger(u16x16 a, u16x16 b) noexcept {
  return as<u16x16>(_mm256_max_epu16(bits(a), bits(b)));
}
inline i16x16 larger(i16x16 a, i16x16 b) noexcept {
  return as<i16x16>(_mm256_max_epi16(bits(a), bits(b)));
}
inline u32x8 larger(u32x8 a, u32x8 b) noexcept {
  return as<u32x8>(_mm256_max_epu32(bits(a), bits(b)));
}

}  // namespace stof::dsp::avx2
