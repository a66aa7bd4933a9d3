#include "dsp/fusion/unwrap/count_votes.h"

#include <array>
#include <cstddef>

#include "dsp/base/avx2.h"
#include "dsp/base/check.h"
#include "dsp/fusion/project/project.h"

namespace stof::dsp::avx2 {
namespace {

constexpr std::size_t kLanes = 8;

// The first sample of each place's window along an axis.
i32x8 first_samples(const std::int32_t* places, int step_bits, int count) noexcept {
  const int step = kPositionOne << step_bits;
  const i32x8 from = load<i32x8>(places) - all(std::int32_t{step + step / 2});
  const __m256i first = bits(from >> (kPositionBits + step_bits));
  return as<i32x8>(_mm256_min_epi32(_mm256_max_epi32(first, _mm256_set1_epi32(-kGridBorder)),
                                    _mm256_set1_epi32(count)));
}

__m128i two_rows(const QuarterMm* at, std::ptrdiff_t stride) noexcept {
  // NOLINTNEXTLINE: four elements of any alignment
  return _mm_unpacklo_epi64(_mm_loadl_epi64(reinterpret_cast<const __m128i*>(at)),
                            // NOLINTNEXTLINE: likewise
                            _mm_loadl_epi64(reinterpret_cast<const __m128i*>(at + stride)));
}
u16x16 window(const QuarterMm* at, std::ptrdiff_t stride) noexcept {
  return as<u16x16>(_mm256_set_m128i(two_rows(at + 2 * stride, stride), two_rows(at, stride)));
}

__m256i at_most(u16x16 a, u16x16 b) noexcept {
  return _mm256_cmpeq_epi16(bits(smaller(a, b)), bits(a));
}

// Of eight readings, as in count_votes_neon.cpp.
struct Bounds {
  alignas(16) std::array<std::uint16_t, kLanes> agree_low;
  alignas(16) std::array<std::uint16_t, kLanes> agree_high;
  alignas(16) std::array<std::uint16_t, kLanes> apart_low;
  alignas(16) std::array<std::uint16_t, kLanes> apart_high;
};

// One field of 5 bits for each of the three counts, in every lane.
__m256i judge(u16x16 low, u16x16 high, const Bounds& bounds, std::size_t lane) noexcept {
  const __m256i unknown = _mm256_cmpeq_epi16(bits(high), _mm256_setzero_si256());
  const __m256i agree = _mm256_and_si256(at_most(low, all(bounds.agree_low[lane])),
                                         at_most(all(bounds.agree_high[lane]), high));
  const __m256i close = _mm256_and_si256(at_most(low, all(bounds.apart_low[lane])),
                                         at_most(all(bounds.apart_high[lane]), high));
  const __m256i known_one = _mm256_andnot_si256(unknown, _mm256_set1_epi16(1));
  const __m256i agree_one = _mm256_and_si256(agree, _mm256_set1_epi16(Votes::kField));
  const __m256i apart_one = _mm256_andnot_si256(_mm256_or_si256(close, unknown),
                                                _mm256_set1_epi16(Votes::kField * Votes::kField));
  return _mm256_or_si256(_mm256_or_si256(known_one, agree_one), apart_one);
}

__m128i eight(const QuarterMm* p) noexcept {
  return _mm_loadu_si128(reinterpret_cast<const __m128i*>(p));  // NOLINT: any alignment
}
void put(std::array<std::uint16_t, kLanes>& lanes, __m128i v) noexcept {
  store_bits(lanes.data(), v);
}

Bounds bounds_of(__m128i depth, __m128i tolerance, QuarterMm far_off) noexcept {
  const __m128i far = _mm_set1_epi16(static_cast<std::int16_t>(far_off));
  Bounds out;
  put(out.agree_low, _mm_adds_epu16(depth, tolerance));
  put(out.agree_high, _mm_max_epu16(_mm_subs_epu16(depth, tolerance), _mm_set1_epi16(1)));
  put(out.apart_low, _mm_adds_epu16(depth, far));
  put(out.apart_high, _mm_subs_epu16(depth, far));
  return out;
}

// Sums of the lanes of eight vectors, one after the other in either half: to be added.
__m256i sums(const std::array<u16x16, kLanes>& v) noexcept {
  const __m256i a = _mm256_hadd_epi16(bits(v[0]), bits(v[1]));
  const __m256i b = _mm256_hadd_epi16(bits(v[2]), bits(v[3]));
  const __m256i c = _mm256_hadd_epi16(bits(v[4]), bits(v[5]));
  const __m256i d = _mm256_hadd_epi16(bits(v[6]), bits(v[7]));
  return _mm256_hadd_epi16(_mm256_hadd_epi16(a, b), _mm256_hadd_epi16(c, d));
}

}  // namespace

void count_votes(const Places& places, const SampleGrid& grid, QuarterMm far_off,
                 std::span<Votes> votes) noexcept {
  const std::size_t n = votes.size();
  STOF_CHECK(places.u.size() == n && places.v.size() == n && places.depth.size() == n &&
             places.tolerance.size() == n);
  std::size_t x = 0;
  for (; x + kLanes <= n; x += kLanes) {
    const __m128i depth = eight(&places.depth[x]);
    __m128i counts = _mm_setzero_si128();
    if (_mm_testz_si128(depth, depth) == 0) {  // often there is nothing in a whole vector
      const i32x8 i = first_samples(&places.u[x], grid.step_bits, grid.columns);
      const i32x8 j = first_samples(&places.v[x], grid.step_bits, grid.rows);
      const i32x8 first = j * all(static_cast<std::int32_t>(grid.stride)) + i;
      const Bounds bounds = bounds_of(depth, eight(&places.tolerance[x]), far_off);
      std::array<u16x16, kLanes> found;
      for (std::size_t lane = 0; lane < kLanes; ++lane) {
        const std::ptrdiff_t at = first[lane];
        found[lane] = as<u16x16>(judge(window(grid.low + at, grid.stride),
                                       window(grid.high + at, grid.stride), bounds, lane));
      }
      const __m256i both = sums(found);
      const __m128i none = _mm_cmpeq_epi16(depth, _mm_setzero_si128());
      counts = _mm_andnot_si128(
          none, _mm_add_epi16(_mm256_castsi256_si128(both), _mm256_extracti128_si256(both, 1)));
    }
    store_half(&votes[x].packed, as<u16x16>(_mm256_castsi128_si256(counts)));
  }
  ref::count_votes({places.u.subspan(x), places.v.subspan(x), places.depth.subspan(x),
                    places.tolerance.subspan(x)},
                   grid, far_off, votes.subspan(x));
}

}  // namespace stof::dsp::avx2
