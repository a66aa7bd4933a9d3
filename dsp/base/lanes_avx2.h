#pragma once

#include <bit>
#include <cstddef>
#include <cstdint>

#include "dsp/base/avx2.h"

// base/lanes_neon.h for *_avx2.cpp files: vectors of u8 and u16 lanes by the same names, for
// x_body.h headers.
namespace stof::dsp::avx2 {

#define STOF_VARIANT avx2
#define STOF_NARROWER neon

// The common part of both kinds.
template <typename LaneType, std::size_t kCount>
struct LanesOf {
  using Lane = LaneType;
  using V = typename VectorOf<Lane>::type;
  static constexpr std::size_t kLanes = kCount;

  static V load(const Lane* p) noexcept { return avx2::load<V>(p); }
  static void store(Lane* p, V v) noexcept { avx2::store(p, v); }
  static V all(Lane v) noexcept { return avx2::all(v); }
  static V difference(V a, V b) noexcept { return larger(a, b) - smaller(a, b); }
  static V smaller(V a, V b) noexcept { return avx2::smaller(a, b); }
  static V larger(V a, V b) noexcept { return avx2::larger(a, b); }
  static V at_most(V a, V b) noexcept { return equal(smaller(a, b), a); }
  static V equal(V a, V b) noexcept { return as<V>(bits(a == b)); }
  // Lane i holds what was in lane i - 1, or i + 1; a lane of the neighbouring vector ends the gap.
  static V one_up(V before, V v) noexcept {
    return as<V>(_mm256_alignr_epi8(bits(v), middle(before, v), 16 - sizeof(Lane)));
  }
  static V one_down(V v, V after) noexcept {
    return as<V>(_mm256_alignr_epi8(middle(v, after), bits(v), sizeof(Lane)));
  }

 private:
  // The upper half of a and the lower one of b.
  static __m256i middle(V a, V b) noexcept {
    return _mm256_permute2x128_si256(bits(a), bits(b), 0x21);
  }
};

template <typename Lane>
struct Lanes;

template <>
struct Lanes<std::uint8_t> : LanesOf<std::uint8_t, 32> {
  static V add_saturated(V a, V b) noexcept { return as<V>(_mm256_adds_epu8(bits(a), bits(b))); }
  static V select(V mask, V a, V b) noexcept {
    return as<V>(_mm256_blendv_epi8(bits(b), bits(a), bits(mask)));
  }
  // The smallest lane in every lane.
  static V lowest(V v) noexcept {
    const __m128i half =
        _mm_min_epu8(_mm256_castsi256_si128(bits(v)), _mm256_extracti128_si256(bits(v), 1));
    const __m128i pairs = _mm_min_epu8(half, _mm_srli_epi16(half, 8));  // high bytes become 0
    return as<V>(_mm256_broadcastb_epi8(_mm_minpos_epu16(pairs)));
  }
  // A bit for each lane.
  static std::uint32_t mask_of(V mask) noexcept {
    return std::bit_cast<std::uint32_t>(_mm256_movemask_epi8(bits(mask)));
  }
};

template <>
struct Lanes<std::uint16_t> : LanesOf<std::uint16_t, 16> {
  static V add_saturated(V a, V b) noexcept { return as<V>(_mm256_adds_epu16(bits(a), bits(b))); }
  static V select(V mask, V a, V b) noexcept {
    return as<V>(_mm256_blendv_epi8(bits(b), bits(a), bits(mask)));
  }
  static V subtract_saturated(V a, V b) noexcept {
    return as<V>(_mm256_subs_epu16(bits(a), bits(b)));
  }
  static V rounded_mean(V a, V b) noexcept { return as<V>(_mm256_avg_epu16(bits(a), bits(b))); }
  // Signed: a / 16, rounded down; (a b + 2^14) >> 15.
  static V signed_sixteenth(V a) noexcept { return as<V>(_mm256_srai_epi16(bits(a), 4)); }
  static V signed_scaled_product(V a, V b) noexcept {
    return as<V>(_mm256_mulhrs_epi16(bits(a), bits(b)));
  }
  // Bytes, a lane each.
  static V load_bytes(const std::uint8_t* p) noexcept {
    return as<V>(
        _mm256_cvtepu8_epi16(_mm_loadu_si128(reinterpret_cast<const __m128i*>(p))));  // NOLINT
  }
  static void store_bytes(std::uint8_t* p, V v) noexcept {
    const __m256i packed = _mm256_packus_epi16(bits(v), bits(v));
    store_bits(p, _mm256_castsi256_si128(_mm256_permute4x64_epi64(packed, 0x08)));
  }
  static bool any(V mask) noexcept { return _mm256_testz_si256(bits(mask), bits(mask)) == 0; }
  static V lowest(V v) noexcept {
    const __m128i half =
        _mm_min_epu16(_mm256_castsi256_si128(bits(v)), _mm256_extracti128_si256(bits(v), 1));
    return as<V>(_mm256_broadcastw_epi16(_mm_minpos_epu16(half)));
  }
};

}  // namespace stof::dsp::avx2
