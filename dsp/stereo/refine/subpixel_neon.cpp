#include "dsp/stereo/refine/subpixel.h"

#include <algorithm>
#include <array>
#include <cstddef>

#include "dsp/base/check.h"
#include "dsp/base/simd.h"

namespace stof::dsp::neon {
namespace {

// Raw disparities are written as plain int16.
std::int16_t* raw(std::span<Disparity> out, std::size_t x) noexcept {
  static_assert(sizeof(Disparity) == sizeof(std::int16_t));
  return &out[x].raw;
}

int16x8_t whole(int16x8_t winner, int16x8_t first) noexcept {
  const int16x8_t value = vshlq_n_s16(vaddq_s16(winner, first), Disparity::kFractionBits);
  return vbslq_s16(vceqq_s16(winner, vdupq_n_s16(kNoWinner)), vdupq_n_s16(Disparity::none().raw),
                   value);
}

// The costs around the winners of four pixels, and zeros where a neighbour is missing or costs
// less.
struct Around {
  std::array<std::uint32_t, 4> before;
  std::array<std::uint32_t, 4> best;
  std::array<std::uint32_t, 4> after;
};

template <typename Sum>
Around look_around(const Sum* costs, std::size_t lanes, const std::int16_t* winners) noexcept {
  Around around{};  // without neighbours all three are 0: no rise, no shift
  for (std::size_t p = 0; p < 4; ++p) {
    const std::int16_t winner = winners[p];
    if (winner <= 0 || static_cast<std::size_t>(winner) + 1 >= lanes) {
      continue;
    }
    const Sum* const at = costs + p * lanes + static_cast<std::size_t>(winner);
    if (at[-1] != kNoCost<Sum> && at[1] != kNoCost<Sum> && at[-1] >= at[0] && at[1] >= at[0]) {
      around.before[p] = at[-1];
      around.best[p] = at[0];
      around.after[p] = at[1];
    }
  }
  return around;
}

// Sixteenths in -8..8: |difference| * 16 reaches (2 k - 1) * rise for k = 1.. once for each of
// them.
template <CostFit kFit>
int32x4_t shift_of(const Around& around) noexcept {
  const uint32x4_t before = vld1q_u32(around.before.data());
  const uint32x4_t after = vld1q_u32(around.after.data());
  const uint32x4_t best = vld1q_u32(around.best.data());
  const uint32x4_t higher = vsubq_u32(vmaxq_u32(before, after), best);
  const uint32x4_t lower = vsubq_u32(vminq_u32(before, after), best);
  const uint32x4_t rise = kFit == CostFit::kEquiangular ? higher : vaddq_u32(higher, lower);
  const uint32x4_t size =
      vshlq_n_u32(vsubq_u32(vmaxq_u32(before, after), vminq_u32(before, after)), 4);
  const uint32x4_t two_rises = vshlq_n_u32(rise, 1);
  uint32x4_t bound = rise;
  uint32x4_t sixteenths = vdupq_n_u32(0);
  for (int k = 0; k < 8; ++k) {
    sixteenths = vsubq_u32(sixteenths, vcgeq_u32(size, bound));  // a true mask is -1
    bound = vaddq_u32(bound, two_rises);
  }
  sixteenths = vandq_u32(sixteenths, vcgtq_u32(rise, vdupq_n_u32(0)));
  const int32x4_t shift = vreinterpretq_s32_u32(sixteenths);
  return vbslq_s32(vcltq_u32(before, after), vnegq_s32(shift), shift);
}

template <CostFit kFit, typename Sum>
void refine(std::span<const Sum> costs, int lanes, int min_disparity,
            std::span<const std::int16_t> winners, std::span<Disparity> out) noexcept {
  const std::size_t count = static_cast<std::size_t>(lanes);
  const std::size_t n = winners.size();
  STOF_CHECK((kFit == CostFit::kNone || costs.size() == n * count) && out.size() == n);
  const int16x8_t first = vdupq_n_s16(static_cast<std::int16_t>(min_disparity));
  std::size_t x = 0;
  for (; x + 8 <= n; x += 8) {
    const int16x8_t unfitted = whole(vld1q_s16(winners.data() + x), first);
    if constexpr (kFit == CostFit::kNone) {
      vst1q_s16(raw(out, x), unfitted);
    } else {
      const Sum* const pixel = costs.data() + x * count;
      const int32x4_t low = shift_of<kFit>(look_around(pixel, count, winners.data() + x));
      const int32x4_t high =
          shift_of<kFit>(look_around(pixel + 4 * count, count, winners.data() + x + 4));
      const int16x8_t shift = vcombine_s16(vmovn_s32(low), vmovn_s32(high));
      vst1q_s16(raw(out, x), vaddq_s16(unfitted, shift));
    }
  }
  ref::refine_winners(kFit == CostFit::kNone ? costs : costs.subspan(x * count), lanes, kFit,
                      min_disparity, winners.subspan(x), out.subspan(x));
}

}  // namespace

template <typename Sum>
void refine_winners(std::span<const Sum> costs, int lanes, CostFit fit, int min_disparity,
                    std::span<const std::int16_t> winners, std::span<Disparity> out) noexcept {
  switch (fit) {
    case CostFit::kNone:
      return refine<CostFit::kNone>(costs, lanes, min_disparity, winners, out);
    case CostFit::kEquiangular:
      return refine<CostFit::kEquiangular>(costs, lanes, min_disparity, winners, out);
    case CostFit::kParabola:
      return refine<CostFit::kParabola>(costs, lanes, min_disparity, winners, out);
  }
}

STOF_INSTANTIATE(RefineWinners, refine_winners, std::uint16_t, std::uint32_t);

}  // namespace stof::dsp::neon
