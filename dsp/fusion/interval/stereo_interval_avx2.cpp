#include "dsp/fusion/interval/stereo_interval.h"

#include <cstddef>

#include "dsp/base/avx2.h"
#include "dsp/base/check.h"

namespace stof::dsp::avx2 {
namespace {

constexpr std::size_t kLanes = 16;

// Entries of the table, 0 .. 65535, as low + 65536 high.
i32x8 look_up(const DepthInterval* bounds, i32x8 at) noexcept {
  static_assert(sizeof(DepthInterval) == sizeof(std::int32_t));
  // NOLINTNEXTLINE: an interval in 32 bits
  return as<i32x8>(_mm256_i32gather_epi32(reinterpret_cast<const int*>(bounds), bits(at), 4));
}

struct Ends {
  i32x8 low;
  i32x8 high;
};

// The near ends and far ends of eight disparities of the table.
Ends ends(const DepthInterval* bounds, __m128i at, __m128i half) noexcept {
  const i32x8 middle = as<i32x8>(_mm256_cvtepu16_epi32(at));
  const i32x8 half_width = as<i32x8>(_mm256_cvtepu16_epi32(half));
  const i32x8 near = look_up(bounds, middle + half_width);
  const i32x8 far = look_up(bounds, middle - half_width);
  return {near & all(std::int32_t{0xFFFF}), as<i32x8>(_mm256_srli_epi32(bits(far), 16))};
}

u16x16 packed(i32x8 first, i32x8 second) noexcept {
  return as<u16x16>(_mm256_permute4x64_epi64(_mm256_packus_epi32(bits(first), bits(second)), 0xD8));
}

}  // namespace

void stereo_interval(std::span<const Disparity> disparity, std::span<const std::uint8_t> half,
                     const DisparityTable& table, std::span<QuarterMm> low,
                     std::span<QuarterMm> high) noexcept {
  STOF_CHECK(half.size() == disparity.size() && low.size() == disparity.size() &&
             high.size() == disparity.size());
  STOF_CHECK(table.size() >= 1 && table.bounds.size() <= 65536);
  const u16x16 last = all(static_cast<std::uint16_t>(table.size() - 1));
  const i16x16 first = all(table.first_raw);
  const i16x16 none = all(Disparity::none().raw);
  const u16x16 nearest = all(static_cast<std::uint16_t>(table.max_range - (table.max_range > 0)));
  const u16x16 any = all(static_cast<std::uint16_t>(table.max_range > 0 ? 0xFFFF : 0));
  std::size_t x = 0;
  for (; x + kLanes <= disparity.size(); x += kLanes) {
    const i16x16 raw = load<i16x16>(&disparity[x].raw);
    const u16x16 step = as<u16x16>(bits(raw - first));
    const __m256i below = _mm256_cmpgt_epi16(bits(first), bits(raw));
    const __m256i outside = _mm256_or_si256(below, _mm256_cmpeq_epi16(bits(raw), bits(none)));
    const __m256i within = _mm256_cmpeq_epi16(bits(smaller(step, last)), bits(step));
    const u16x16 inside = as<u16x16>(_mm256_andnot_si256(outside, within));
    const __m256i at = bits((step & inside) + all(std::uint16_t{kMostHalfWidth}));
    // NOLINTNEXTLINE: sixteen bytes of any alignment
    const __m128i bytes = _mm_loadu_si128(reinterpret_cast<const __m128i*>(&half[x]));
    const __m256i half_width = _mm256_cvtepu8_epi16(bytes);
    const Ends a =
        ends(table.bounds.data(), _mm256_castsi256_si128(at), _mm256_castsi256_si128(half_width));
    const Ends b = ends(table.bounds.data(), _mm256_extracti128_si256(at, 1),
                        _mm256_extracti128_si256(half_width, 1));
    const u16x16 near = packed(a.low, b.low);
    const u16x16 some =
        as<u16x16>(_mm256_cmpeq_epi16(bits(smaller(near, nearest)), bits(near))) & inside & any;
    store(&low[x], near & some);
    store(&high[x], packed(a.high, b.high) & some);
  }
  ref::stereo_interval(disparity.subspan(x), half.subspan(x), table, low.subspan(x),
                       high.subspan(x));
}

}  // namespace stof::dsp::avx2
