#include "dsp/stereo/search/block_winners.h"

#include <array>
#include <cstddef>
#include <memory>

#include "dsp/base/simd.h"
#include "dsp/stereo/search/block_fits_body.h"

namespace stof::dsp::neon {
namespace {

constexpr std::uint16_t kNumbers[8] = {0, 1, 2, 3, 4, 5, 6, 7};

// The lowest element of each of eight vectors, and where it stands first.
void find_lowest(const std::uint16_t* eights, uint16x8_t& lowest, uint16x8_t& where) noexcept {
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
  v[0] = vorrq_u16(number, vcgtq_u16(v[0], vdupq_laneq_u16(lowest, 0)));
  v[1] = vorrq_u16(number, vcgtq_u16(v[1], vdupq_laneq_u16(lowest, 1)));
  v[2] = vorrq_u16(number, vcgtq_u16(v[2], vdupq_laneq_u16(lowest, 2)));
  v[3] = vorrq_u16(number, vcgtq_u16(v[3], vdupq_laneq_u16(lowest, 3)));
  v[4] = vorrq_u16(number, vcgtq_u16(v[4], vdupq_laneq_u16(lowest, 4)));
  v[5] = vorrq_u16(number, vcgtq_u16(v[5], vdupq_laneq_u16(lowest, 5)));
  v[6] = vorrq_u16(number, vcgtq_u16(v[6], vdupq_laneq_u16(lowest, 6)));
  v[7] = vorrq_u16(number, vcgtq_u16(v[7], vdupq_laneq_u16(lowest, 7)));
  where = least_of_each(v);
#endif
}

// a / b without its fraction, lane by lane, where that is below 9: other processors than ARM divide
// floats, of which a quotient that is no whole number lies 2^-16 from one at least. 0 / 0 is 0.
uint16x8_t small_quotient(uint16x8_t a, uint16x8_t b) noexcept {
#if defined(__SSE4_1__)
  const __m128i zero = _mm_setzero_si128();
  const auto quotient = [](__m128i of, __m128i by) noexcept {
    return _mm_cvttps_epi32(_mm_div_ps(_mm_cvtepi32_ps(of), _mm_cvtepi32_ps(by)));
  };
  const __m128i n = std::bit_cast<__m128i>(a);
  const __m128i d = std::bit_cast<__m128i>(b);
  const __m128i low = quotient(_mm_unpacklo_epi16(n, zero), _mm_unpacklo_epi16(d, zero));
  const __m128i high = quotient(_mm_unpackhi_epi16(n, zero), _mm_unpackhi_epi16(d, zero));
  return vbicq_u16(std::bit_cast<uint16x8_t>(_mm_packs_epi32(low, high)),
                   vceqq_u16(b, vdupq_n_u16(0)));
#else
  // Eights, fours, twos and ones, a bit each. What cannot be taken away wraps to a larger number.
  const uint16x8_t two = vqaddq_u16(b, b);
  const uint16x8_t four = vqaddq_u16(two, two);
  const uint16x8_t eight = vqaddq_u16(four, four);
  const uint16x8_t below_eight = vminq_u16(a, vsubq_u16(a, eight));
  const uint16x8_t below_four = vminq_u16(below_eight, vsubq_u16(below_eight, four));
  const uint16x8_t below_two = vminq_u16(below_four, vsubq_u16(below_four, two));
  uint16x8_t count = vshrq_n_u16(vcgeq_u16(below_two, b), 15);
  count = vsliq_n_u16(count, vcgeq_u16(below_four, two), 1);
  count = vsliq_n_u16(count, vcgeq_u16(below_eight, four), 2);
  count = vsliq_n_u16(count, vcgeq_u16(a, eight), 3);
  return vandq_u16(count, vandq_u16(vtstq_u16(b, b), vdupq_n_u16(15)));
#endif
}

struct Neon {
  using V = uint16x8_t;
  static constexpr std::size_t kLanes = 8;

  static V load(const std::uint16_t* p) noexcept { return vld1q_u16(std::assume_aligned<16>(p)); }
  static void store(std::uint16_t* p, V v) noexcept {
    vst1q_u16(p, v);
    unmutate(p);
  }
  static void store_eight(std::uint16_t* p, V v) noexcept { store(p, v); }
  static void store_parts(std::uint16_t* p, V v) noexcept { store(p, v); }
  static void add_parts(const std::uint16_t* parts, std::size_t first,
                        std::uint32_t* totals) noexcept {
    const auto of = [&](int k) noexcept { return vpaddlq_u16(vld1q_u16(parts + 8 * k)); };
    const uint32x4_t sums = vpaddq_u32(vpaddq_u32(of(0), of(1)), vpaddq_u32(of(2), of(3)));
    vst1q_u32(totals, first == 0 ? sums : vaddq_u32(sums, vld1q_u32(totals)));
    unmutate(totals);
  }
  static V add(V a, V b) noexcept { return vaddq_u16(a, b); }
  static V sub(V a, V b) noexcept { return vsubq_u16(a, b); }
  static V smaller(V a, V b) noexcept { return vminq_u16(a, b); }
  static V without(V a, V b) noexcept { return vbicq_u16(a, b); }
  static V either(V a, V b) noexcept { return vorrq_u16(a, b); }
  static V eighth(V a) noexcept { return vshrq_n_u16(a, 3); }
  static V numbers(std::size_t v) noexcept { return vdupq_n_u16(static_cast<std::uint16_t>(v)); }

  static V outside(int first, int begin, int end) noexcept {
    // Less `begin`, wrapped, those inside are at most the last one. Of none, all are far behind.
    const int last = std::max(end - begin - 1, 0);
    const int from = end > begin ? begin : -32768;
    const V least = vaddq_u16(vld1q_u16(kNumbers), vdupq_n_u16(static_cast<std::uint16_t>(-from)));
    return vcgtq_u16(vaddq_u16(least, vdupq_n_u16(static_cast<std::uint16_t>(first))),
                     vdupq_n_u16(static_cast<std::uint16_t>(last)));
  }

  static uint8x16_t pixel(const std::uint8_t* p) noexcept { return vdupq_n_u8(*p); }
  using Change = uint8x16x2_t;
  static Change change(uint8x16_t in, const std::uint8_t* new_right, uint8x16_t gone,
                       const std::uint8_t* old_right) noexcept {
    return {{simd::difference_of_small(in, vld1q_u8(new_right)),
             simd::difference_of_small(gone, vld1q_u8(old_right))}};
  }
  static void add_change(const Change& change, V& a, V& b) noexcept {
    simd::add_eight_times(change.val[0], change.val[1], a, b);
  }

  static constexpr std::size_t kColumns = 8;

  static bool lowest(const std::uint16_t* eights, std::size_t first, std::uint16_t* costs,
                     std::int16_t* winners) noexcept {
    V sums;
    V lane;
    find_lowest(eights, sums, lane);
    const V group = vshlq_n_u16(vandq_u16(sums, vdupq_n_u16(7)), 3);
    const int16x8_t winner = vreinterpretq_s16_u16(
        vaddq_u16(vaddq_u16(group, lane), vdupq_n_u16(static_cast<std::uint16_t>(first & ~63U))));
    const V cost = vshrq_n_u16(sums, 3);
    int16x8_t best = winner;
    if (first == 0) {
      store(costs, cost);
    } else {
      const V before = vld1q_u16(costs);
      best = vbslq_s16(vcltq_u16(cost, before), winner, vld1q_s16(winners));
      store(costs, vminq_u16(cost, before));
    }
    store_winners(winners, best);
    const uint8x8_t zeros = vmovn_u16(vceqq_s16(best, vdupq_n_s16(0)));
    return vget_lane_u64(vreinterpret_u64_u8(zeros), 0) != 0;
  }

  template <int kShift>
  static void fit(const BlockRow& row, const std::uint16_t* columns,
                  const std::array<std::uint16_t, kColumns>& places, const std::uint16_t* costs,
                  const std::int16_t* winners, std::int16_t* kept, std::int16_t* fitted) noexcept {
    const int16x8_t winner = vld1q_s16(winners);
    const int16x8_t none = vdupq_n_s16(kNoWinner);
    const int16x8_t base =
        vaddq_s16(winner, vdupq_n_s16(static_cast<std::int16_t>(row.min_disparity)));
    int16x8_t out = vshlq_n_s16(base, Disparity::kFractionBits);
    if (row.fit != CostFit::kNone) {
      // From the sums before the winners on. No winner, -1, makes none of these numbers negative.
      const V from = vaddq_u16(vld1q_u16(places.data()),
                               vreinterpretq_u16_s16(vaddq_s16(winner, vdupq_n_s16(1))));
      const V bytes = vshlq_n_u16(from, 1);
      const V a = two_fours<0>(columns - 2, bytes);
      const V b = two_fours<2>(columns - 2, bytes);
      const V c = two_fours<4>(columns - 2, bytes);
      const V d = two_fours<6>(columns - 2, bytes);
      const V low = vuzp1q_u16(a, b);
      const V high = vuzp1q_u16(c, d);
      const V before = shifted<kShift>(vuzp1q_u16(low, high));
      const V after = shifted<kShift>(vuzp2q_u16(low, high));
      const int16x8_t last = vdupq_n_s16(static_cast<std::int16_t>(row.lanes - 1));
      const V missing = vdupq_n_u16(kNoCost<std::uint16_t> >> kShift);
      const V inside = vandq_u16(vcgtq_s16(winner, vdupq_n_s16(0)), vcltq_s16(winner, last));
      const V usable = vandq_u16(inside, vcltq_u16(vmaxq_u16(before, after), missing));
      const V shift = sixteenths(before, vld1q_u16(costs), after, row.fit);
      const int16x8_t signed_shift = vreinterpretq_s16_u16(vandq_u16(shift, usable));
      out = vbslq_s16(vcltq_u16(before, after), vsubq_s16(out, signed_shift),
                      vaddq_s16(out, signed_shift));
    }
    store_winners(kept, winner);
    out = vbslq_s16(vceqq_s16(winner, none), vdupq_n_s16(Disparity::none().raw), out);
    store_winners(fitted, out);
  }

 private:
  // Four sums each from two places on.
  template <int kLane>
  static V two_fours(const std::uint16_t* columns, V bytes) noexcept {
    const auto four = [columns](std::uint16_t place) noexcept {
      const std::byte* const at = reinterpret_cast<const std::byte*>(columns) + place;  // NOLINT
      return vld1_u16(reinterpret_cast<const std::uint16_t*>(at));                      // NOLINT
    };
    return vcombine_u16(four(vgetq_lane_u16(bytes, kLane)), four(vgetq_lane_u16(bytes, kLane + 1)));
  }
  static void store_winners(std::int16_t* p, int16x8_t v) noexcept {
    vst1q_s16(p, v);
    unmutate(p);
  }

  template <int kShift>
  static V shifted(V v) noexcept {
    if constexpr (kShift == 0) {
      return v;
    } else {
      return vshrq_n_u16(v, kShift);
    }
  }

  // 0..8: (16 |before - after| + rise) / (2 rise).
  static V sixteenths(V before, V best, V after, CostFit fit) noexcept {
    const V higher = vsubq_u16(vmaxq_u16(before, after), best);
    const V lower = vsubq_u16(vminq_u16(before, after), best);
    const V rise = fit == CostFit::kEquiangular ? higher : vqaddq_u16(higher, lower);
    const V reach = vaddq_u16(vshlq_n_u16(vsubq_u16(higher, lower), 3), vshrq_n_u16(rise, 1));
    return small_quotient(reach, rise);
  }
};

}  // namespace

void block_winners(const BlockPixels& pixels, const BlockRow& row, std::span<std::uint16_t> columns,
                   const BlockMatches& out) noexcept {
  block_winners_body::pass<Neon>(pixels, row, columns, out);
}

}  // namespace stof::dsp::neon
