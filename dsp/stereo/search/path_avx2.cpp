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
struct Lanes;

template <>
struct Lanes<std::uint8_t> {
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
struct Lanes<std::uint16_t> {
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

template <typename Cost>
void paths_from_left(std::span<const Cost> costs, int lanes, Cost small,
                     std::span<const Cost> large, std::span<Cost> paths) noexcept {
  along<Lanes<Cost>>(costs, lanes, small, large, paths, true);
}

template <typename Cost>
void paths_from_right(std::span<const Cost> costs, int lanes, Cost small,
                      std::span<const Cost> large, std::span<Cost> paths) noexcept {
  along<Lanes<Cost>>(costs, lanes, small, large, paths, false);
}

template <typename Cost>
void paths_both_ways(std::span<const Cost> costs, int lanes, Cost small,
                     std::span<const Cost> large_from_left, std::span<const Cost> large_from_right,
                     std::span<Cost> from_left, std::span<Cost> from_right) noexcept {
  if (lanes % static_cast<int>(Lanes<Cost>::kLanes) != 0) {
    neon::paths_both_ways(costs, lanes, small, large_from_left, large_from_right, from_left,
                          from_right);
    return;
  }
  both_ways<Lanes<Cost>>(costs, lanes, small, large_from_left, large_from_right, from_left,
                         from_right);
}

template <typename Cost>
void paths_across(std::span<const Cost> costs, std::span<const Cost> before, int shift, int lanes,
                  Cost small, std::span<const Cost> large, std::span<Cost> paths) noexcept {
  if (lanes % static_cast<int>(Lanes<Cost>::kLanes) != 0) {
    neon::paths_across(costs, before, shift, lanes, small, large, paths);
    return;
  }
  across<Lanes<Cost>>(costs, before, shift, lanes, small, large, paths);
}

template <typename Cost>
void paths_of_axes(const AxesRow<Cost>& row, std::span<Cost> front, std::span<const Cost> others,
                   std::span<Cost> sums) noexcept {
  if (row.lanes % static_cast<int>(Lanes<Cost>::kLanes) != 0) {
    neon::paths_of_axes(row, front, others, sums);
    return;
  }
  axes<Lanes<Cost>>(row, front, others, sums);
}

template PathsAlong<std::uint16_t> paths_from_left<std::uint16_t>;
template PathsAlong<std::uint16_t> paths_from_right<std::uint16_t>;
template PathsBothWays<std::uint8_t> paths_both_ways<std::uint8_t>;
template PathsBothWays<std::uint16_t> paths_both_ways<std::uint16_t>;
template PathsAcross<std::uint8_t> paths_across<std::uint8_t>;
template PathsAcross<std::uint16_t> paths_across<std::uint16_t>;
template PathsOfAxes<std::uint8_t> paths_of_axes<std::uint8_t>;
template PathsOfAxes<std::uint16_t> paths_of_axes<std::uint16_t>;

}  // namespace stof::dsp::avx2
