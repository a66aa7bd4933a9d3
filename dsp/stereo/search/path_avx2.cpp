#include "dsp/stereo/search/path.h"

#include <cstddef>
#include <cstdint>

#include "dsp/base/avx2.h"
#include "dsp/stereo/search/path_body.h"

namespace stof::dsp::avx2 {
namespace {

using path_body::across;
using path_body::along;
using path_body::axes;
using path_body::both_ways;

// The upper half of a and the lower one of b.
__m256i middle(__m256i a, __m256i b) noexcept { return _mm256_permute2x128_si256(a, b, 0x21); }

template <typename Sum>
struct Avx2;

template <>
struct Avx2<std::uint8_t> {
  using Cost = std::uint8_t;
  using V = u8x32;
  static constexpr std::size_t kLanes = 32;

  static V add_saturated(V a, V b) noexcept { return as<V>(_mm256_adds_epu8(bits(a), bits(b))); }
  static V total(V a, V b) noexcept { return add_saturated(a, b); }
  static V one_up(V before, V v) noexcept {
    return as<V>(_mm256_alignr_epi8(bits(v), middle(bits(before), bits(v)), 15));
  }
  static V one_down(V v, V after) noexcept {
    return as<V>(_mm256_alignr_epi8(middle(bits(v), bits(after)), bits(v), 1));
  }
  static V lowest(V v) noexcept {
    const __m128i half =
        _mm_min_epu8(_mm256_castsi256_si128(bits(v)), _mm256_extracti128_si256(bits(v), 1));
    const __m128i pairs = _mm_min_epu8(half, _mm_srli_epi16(half, 8));  // high bytes become 0
    return as<V>(_mm256_broadcastb_epi8(_mm_minpos_epu16(pairs)));
  }

  static V load(const Cost* p) noexcept { return avx2::load<V>(p); }
  static void store(Cost* p, V v) noexcept { avx2::store(p, v); }
  static V all(Cost v) noexcept { return avx2::all(v); }
  static V smaller(V a, V b) noexcept { return avx2::smaller(a, b); }
  static V sub(V a, V b) noexcept { return a - b; }
};

template <>
struct Avx2<std::uint16_t> {
  using Cost = std::uint16_t;
  using V = u16x16;
  static constexpr std::size_t kLanes = 16;

  static V add_saturated(V a, V b) noexcept { return as<V>(_mm256_adds_epu16(bits(a), bits(b))); }
  static V total(V a, V b) noexcept { return a + b; }
  static V one_up(V before, V v) noexcept {
    return as<V>(_mm256_alignr_epi8(bits(v), middle(bits(before), bits(v)), 14));
  }
  static V one_down(V v, V after) noexcept {
    return as<V>(_mm256_alignr_epi8(middle(bits(v), bits(after)), bits(v), 2));
  }
  static V lowest(V v) noexcept {
    const __m128i half =
        _mm_min_epu16(_mm256_castsi256_si128(bits(v)), _mm256_extracti128_si256(bits(v), 1));
    return as<V>(_mm256_broadcastw_epi16(_mm_minpos_epu16(half)));
  }

  static V load(const Cost* p) noexcept { return avx2::load<V>(p); }
  static void store(Cost* p, V v) noexcept { avx2::store(p, v); }
  static V all(Cost v) noexcept { return avx2::all(v); }
  static V smaller(V a, V b) noexcept { return avx2::smaller(a, b); }
  static V sub(V a, V b) noexcept { return a - b; }
};

}  // namespace

void paths_from_left(std::span<const std::uint16_t> costs, int lanes, std::uint16_t small,
                     std::span<const std::uint16_t> large,
                     std::span<std::uint16_t> paths) noexcept {
  along<Avx2<std::uint16_t>>(costs, lanes, small, large, paths, true);
}
void paths_from_right(std::span<const std::uint16_t> costs, int lanes, std::uint16_t small,
                      std::span<const std::uint16_t> large,
                      std::span<std::uint16_t> paths) noexcept {
  along<Avx2<std::uint16_t>>(costs, lanes, small, large, paths, false);
}
void paths_both_ways(std::span<const std::uint8_t> costs, int lanes, std::uint8_t small,
                     std::span<const std::uint8_t> large_from_left,
                     std::span<const std::uint8_t> large_from_right,
                     std::span<std::uint8_t> from_left,
                     std::span<std::uint8_t> from_right) noexcept {
  if (lanes % 32 != 0) {
    neon::paths_both_ways(costs, lanes, small, large_from_left, large_from_right, from_left,
                          from_right);
    return;
  }
  both_ways<Avx2<std::uint8_t>>(costs, lanes, small, large_from_left, large_from_right, from_left,
                                from_right);
}
void paths_both_ways(std::span<const std::uint16_t> costs, int lanes, std::uint16_t small,
                     std::span<const std::uint16_t> large_from_left,
                     std::span<const std::uint16_t> large_from_right,
                     std::span<std::uint16_t> from_left,
                     std::span<std::uint16_t> from_right) noexcept {
  both_ways<Avx2<std::uint16_t>>(costs, lanes, small, large_from_left, large_from_right, from_left,
                                 from_right);
}
void paths_across(std::span<const std::uint8_t> costs, std::span<const std::uint8_t> before,
                  int shift, int lanes, std::uint8_t small, std::span<const std::uint8_t> large,
                  std::span<std::uint8_t> paths) noexcept {
  if (lanes % 32 != 0) {
    neon::paths_across(costs, before, shift, lanes, small, large, paths);
    return;
  }
  across<Avx2<std::uint8_t>>(costs, before, shift, lanes, small, large, paths);
}
void paths_across(std::span<const std::uint16_t> costs, std::span<const std::uint16_t> before,
                  int shift, int lanes, std::uint16_t small, std::span<const std::uint16_t> large,
                  std::span<std::uint16_t> paths) noexcept {
  across<Avx2<std::uint16_t>>(costs, before, shift, lanes, small, large, paths);
}
void paths_of_axes(const AxesRow<std::uint8_t>& row, std::span<std::uint8_t> front,
                   std::span<const std::uint8_t> others, std::span<std::uint8_t> sums) noexcept {
  if (row.lanes % 32 != 0) {
    neon::paths_of_axes(row, front, others, sums);
    return;
  }
  axes<Avx2<std::uint8_t>>(row, front, others, sums);
}
void paths_of_axes(const AxesRow<std::uint16_t>& row, std::span<std::uint16_t> front,
                   std::span<const std::uint16_t> others, std::span<std::uint16_t> sums) noexcept {
  axes<Avx2<std::uint16_t>>(row, front, others, sums);
}

}  // namespace stof::dsp::avx2
