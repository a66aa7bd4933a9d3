#include "dsp/fusion/unwrap/count_votes.h"

#include <array>
#include <cstddef>
#include <cstring>

#include "dsp/base/check.h"
#include "dsp/base/simd.h"
#include "dsp/fusion/project/project.h"

namespace stof::dsp::neon {
namespace {

constexpr std::size_t kLanes = 8;

// Of four places, the first samples along an axis.
class FirstSample {
 public:
  FirstSample(int step_bits, int count) noexcept
      : before_(vdupq_n_s32(3 * (kPositionOne << step_bits) / 2)),
        down_(vdupq_n_s32(-(kPositionBits + step_bits))),
        last_(vdupq_n_s32(count)) {}

  int32x4_t of(const std::int32_t* place) const noexcept {
    const int32x4_t first = vshlq_s32(vsubq_s32(vld1q_s32(place), before_), down_);
    return vmaxq_s32(vminq_s32(first, last_), vdupq_n_s32(-kGridBorder));
  }

 private:
  int32x4_t before_;
  int32x4_t down_;
  int32x4_t last_;
};

// Two rows of a window.
uint16x8_t two_rows(const QuarterMm* at, std::ptrdiff_t stride) noexcept {
  return vcombine_u16(vld1_u16(at), vld1_u16(at + stride));
}

// Of eight readings, or of one in all lanes.
struct Bounds {
  uint16x8_t agree_low;   // depth + tolerance
  uint16x8_t agree_high;  // max(depth - tolerance, 1)
  uint16x8_t apart_low;   // depth + far_off
  uint16x8_t apart_high;  // depth - far_off

  static Bounds of(uint16x8_t depth, uint16x8_t tolerance, uint16x8_t far_off) noexcept {
    return {.agree_low = vqaddq_u16(depth, tolerance),
            .agree_high = vmaxq_u16(vqsubq_u16(depth, tolerance), vdupq_n_u16(1)),
            .apart_low = vqaddq_u16(depth, far_off),
            .apart_high = vqsubq_u16(depth, far_off)};
  }
  template <int kLane>
  Bounds lane() const noexcept {
    return {.agree_low = vdupq_laneq_u16(agree_low, kLane),
            .agree_high = vdupq_laneq_u16(agree_high, kLane),
            .apart_low = vdupq_laneq_u16(apart_low, kLane),
            .apart_high = vdupq_laneq_u16(apart_high, kLane)};
  }
};

// Of eight samples, masks.
struct Counted {
  uint16x8_t known;
  uint16x8_t agree;
  uint16x8_t apart;
};

Counted judge(uint16x8_t low, uint16x8_t high, const Bounds& bounds) noexcept {
  const uint16x8_t known = vtstq_u16(high, high);
  const uint16x8_t agree =
      vandq_u16(vcleq_u16(low, bounds.agree_low), vcgeq_u16(high, bounds.agree_high));
  const uint16x8_t outside =
      vorrq_u16(vcgtq_u16(low, bounds.apart_low), vcltq_u16(high, bounds.apart_high));
  return {known, agree, vandq_u16(known, outside)};
}

std::uint16_t count(const SampleGrid& grid, std::ptrdiff_t first, const Bounds& bounds) noexcept {
  const QuarterMm* const low = grid.low + first;
  const QuarterMm* const high = grid.high + first;
  const std::ptrdiff_t stride = grid.stride;
  const Counted upper = judge(two_rows(low, stride), two_rows(high, stride), bounds);
  const Counted lower =
      judge(two_rows(low + 2 * stride, stride), two_rows(high + 2 * stride, stride), bounds);
  // A true mask is -1. One field of 5 bits for each of the three counts, in every lane.
  const uint16x8_t known = vaddq_u16(upper.known, lower.known);
  const uint16x8_t agree = vaddq_u16(upper.agree, lower.agree);
  const uint16x8_t apart = vaddq_u16(upper.apart, lower.apart);
  const uint16x8_t field = vdupq_n_u16(Votes::kField);
  const uint16x8_t sums = vmlaq_u16(known, vmlaq_u16(agree, apart, field), field);
  return static_cast<std::uint16_t>(-vaddvq_u16(sums));
}

// Readings kLane .. 7 of eight, which lie at samples `first`.
template <int kLane>
void count_from(const SampleGrid& grid, const QuarterMm* depth, const std::int32_t* first,
                const Bounds& bounds, std::uint16_t* out) noexcept {
  if constexpr (kLane < kLanes) {
    if (depth[kLane] != kNoDepth) {
      out[kLane] = count(grid, first[kLane], bounds.template lane<kLane>());
    }
    count_from<kLane + 1>(grid, depth, first, bounds, out);
  }
}

}  // namespace

void count_votes(const Places& places, const SampleGrid& grid, QuarterMm far_off,
                 std::span<Votes> votes) noexcept {
  const std::size_t n = votes.size();
  STOF_CHECK(places.u.size() == n && places.v.size() == n && places.depth.size() == n &&
             places.tolerance.size() == n);
  const FirstSample column(grid.step_bits, grid.columns);
  const FirstSample row(grid.step_bits, grid.rows);
  const int32x4_t stride = vdupq_n_s32(static_cast<std::int32_t>(grid.stride));
  std::size_t x = 0;
  for (; x + kLanes <= n; x += kLanes) {
    const std::int32_t* const u = places.u.data() + x;
    const std::int32_t* const v = places.v.data() + x;
    const QuarterMm* const depth = places.depth.data() + x;
    const uint16x8_t depths = vld1q_u16(depth);
    if (vmaxvq_u16(depths) == kNoDepth) {
      vst1q_u16(&votes[x].packed, vdupq_n_u16(0));
      continue;
    }
    std::array<std::int32_t, kLanes> first;
    const int32x4_t low = vmlaq_s32(column.of(u), row.of(v), stride);
    const int32x4_t high = vmlaq_s32(column.of(u + 4), row.of(v + 4), stride);
    std::memcpy(first.data(), &low, sizeof low);
    std::memcpy(first.data() + 4, &high, sizeof high);
    std::array<std::uint16_t, kLanes> some{};
    count_from<0>(grid, depth, first.data(),
                  Bounds::of(depths, vld1q_u16(places.tolerance.data() + x), vdupq_n_u16(far_off)),
                  some.data());
    vst1q_u16(&votes[x].packed, vld1q_u16(some.data()));
  }
  ref::count_votes({places.u.subspan(x), places.v.subspan(x), places.depth.subspan(x),
                    places.tolerance.subspan(x)},
                   grid, far_off, votes.subspan(x));
}

}  // namespace stof::dsp::neon
