#include "dsp/fusion/unwrap/count_votes.h"

#include <algorithm>
#include <array>
#include <cstddef>

#include "dsp/base/check.h"
#include "dsp/base/simd.h"
#include "dsp/fusion/project/project.h"

namespace stof::dsp::neon {
namespace {

constexpr std::size_t kLanes = 8;

int first_sample(std::int32_t place, int step_bits, int count) noexcept {
  const int step = kPositionOne << step_bits;
  const int first = (place - step - step / 2) >> (kPositionBits + step_bits);
  return std::clamp(first, -kGridBorder, count);
}

// Two rows of a window.
uint16x8_t two_rows(const QuarterMm* at, std::ptrdiff_t stride) noexcept {
  return vcombine_u16(vld1_u16(at), vld1_u16(at + stride));
}

struct Bounds {
  uint16x8_t agree_low;   // depth + tolerance
  uint16x8_t agree_high;  // max(depth - tolerance, 1)
  uint16x8_t apart_low;   // depth + far_off
  uint16x8_t apart_high;  // depth - far_off
};

// One field of 5 bits for each of the three counts, in every lane.
uint16x8_t judge(uint16x8_t low, uint16x8_t high, const Bounds& bounds) noexcept {
  const uint16x8_t known = vcgtq_u16(high, vdupq_n_u16(0));
  const uint16x8_t agree =
      vandq_u16(vcleq_u16(low, bounds.agree_low), vcgeq_u16(high, bounds.agree_high));
  const uint16x8_t outside =
      vorrq_u16(vcgtq_u16(low, bounds.apart_low), vcltq_u16(high, bounds.apart_high));
  const uint16x8_t apart = vandq_u16(known, outside);
  const uint16x8_t counts =
      vorrq_u16(vandq_u16(known, vdupq_n_u16(1)), vandq_u16(agree, vdupq_n_u16(Votes::kField)));
  return vorrq_u16(counts, vandq_u16(apart, vdupq_n_u16(Votes::kField * Votes::kField)));
}

std::uint16_t count(const SampleGrid& grid, std::ptrdiff_t first, QuarterMm depth,
                    QuarterMm tolerance, QuarterMm far_off) noexcept {
  const uint16x8_t middle = vdupq_n_u16(depth);
  const uint16x8_t near = vdupq_n_u16(tolerance);
  const uint16x8_t far = vdupq_n_u16(far_off);
  const Bounds bounds{.agree_low = vqaddq_u16(middle, near),
                      .agree_high = vmaxq_u16(vqsubq_u16(middle, near), vdupq_n_u16(1)),
                      .apart_low = vqaddq_u16(middle, far),
                      .apart_high = vqsubq_u16(middle, far)};
  const QuarterMm* const low = grid.low + first;
  const QuarterMm* const high = grid.high + first;
  const std::ptrdiff_t stride = grid.stride;
  const uint16x8_t upper = judge(two_rows(low, stride), two_rows(high, stride), bounds);
  const uint16x8_t lower =
      judge(two_rows(low + 2 * stride, stride), two_rows(high + 2 * stride, stride), bounds);
  return vaddvq_u16(vaddq_u16(upper, lower));
}

}  // namespace

void count_votes(const Places& places, const SampleGrid& grid, QuarterMm far_off,
                 std::span<Votes> votes) noexcept {
  const std::size_t n = votes.size();
  STOF_CHECK(places.u.size() == n && places.v.size() == n && places.depth.size() == n &&
             places.tolerance.size() == n);
  std::size_t x = 0;
  for (; x + kLanes <= n; x += kLanes) {
    std::array<std::uint16_t, kLanes> some{};
    for (std::size_t lane = 0; lane < kLanes; ++lane) {
      const std::size_t at = x + lane;
      if (places.depth[at] != kNoDepth) {
        const int i = first_sample(places.u[at], grid.step_bits, grid.columns);
        const int j = first_sample(places.v[at], grid.step_bits, grid.rows);
        some[lane] =
            count(grid, j * grid.stride + i, places.depth[at], places.tolerance[at], far_off);
      }
    }
    vst1q_u16(&votes[x].packed, vld1q_u16(some.data()));
  }
  ref::count_votes({places.u.subspan(x), places.v.subspan(x), places.depth.subspan(x),
                    places.tolerance.subspan(x)},
                   grid, far_off, votes.subspan(x));
}

}  // namespace stof::dsp::neon
