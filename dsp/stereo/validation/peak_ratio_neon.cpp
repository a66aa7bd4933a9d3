#include "dsp/stereo/validation/peak_ratio.h"

#include <array>
#include <cstddef>

#include "dsp/base/check.h"
#include "dsp/base/lanes_neon.h"
#include "dsp/stereo/cost/sad.h"
#include "dsp/stereo/search/winner.h"

namespace stof::dsp::neon {
namespace {

constexpr std::size_t kAtOnce = 16;

// The lowest of 16 .. 256 costs but those of `first`, first + 1 and first + 2; first may be -1. A
// candidate's number less `first`, wrapped, is 0 .. 2 for these.
template <typename Sum>
Sum best_rival(const Sum* costs, std::size_t lanes, int first) noexcept {
  using L = Lanes<Sum>;
  auto number = L::numbers() - L::all(static_cast<Sum>(first));
  auto lowest = L::all(kNoCost<Sum>);
  for (std::size_t i = 0; i < lanes; i += L::kLanes) {
    const auto near = L::at_most(number, L::all(2));
    lowest = L::smaller(lowest, L::load(costs + i) | near);
    number = number + L::all(L::kLanes);
  }
  return L::smallest(lowest);
}

// floor(255 cost / rival), or 255 where cost >= rival.
uint32x4_t quotient(uint32x4_t cost, uint32x4_t rival) noexcept {
  const float32x4_t scaled = vmulq_f32(vdupq_n_f32(255.0F), vcvtq_f32_u32(cost));
  const uint32x4_t ratio = vcvtq_u32_f32(simd::divide(scaled, vcvtq_f32_u32(rival)));
  return vbslq_u32(vcgeq_u32(cost, rival), vdupq_n_u32(255), ratio);
}

}  // namespace

template <typename Sum>
void peak_ratio(std::span<const Sum> costs, int lanes, std::span<const std::int16_t> winners,
                std::span<std::uint8_t> ratio) noexcept {
  const std::size_t count = static_cast<std::size_t>(lanes);
  STOF_CHECK(lanes >= kCostLanes && lanes % kCostLanes == 0 && lanes <= 256 &&
             costs.size() == winners.size() * count && ratio.size() == winners.size());
  std::size_t x = 0;
  for (; x + kAtOnce <= ratio.size(); x += kAtOnce) {
    // Nothing known: cost 1 and rival 1.
    std::array<std::uint32_t, kAtOnce> cost{};
    std::array<std::uint32_t, kAtOnce> rival{};
    for (std::size_t k = 0; k < kAtOnce; ++k) {
      const std::int16_t winner = winners[x + k];
      const Sum* const pixel = costs.data() + (x + k) * count;
      const Sum own = winner == kNoWinner ? kNoCost<Sum> : pixel[winner];
      const Sum other = own == kNoCost<Sum> ? own : best_rival(pixel, count, winner - 1);
      cost[k] = other == kNoCost<Sum> ? 1 : own;
      rival[k] = other == kNoCost<Sum> ? 1 : other;
    }
    std::array<uint16x4_t, 4> parts{};
    for (std::size_t k = 0; k < 4; ++k) {
      parts[k] =
          vmovn_u32(quotient(vld1q_u32(cost.data() + 4 * k), vld1q_u32(rival.data() + 4 * k)));
    }
    const uint8x8_t low = vmovn_u16(vcombine_u16(parts[0], parts[1]));
    const uint8x8_t high = vmovn_u16(vcombine_u16(parts[2], parts[3]));
    vst1q_u8(ratio.data() + x, vcombine_u8(low, high));
  }
  ref::peak_ratio(costs.subspan(x * count), lanes, winners.subspan(x), ratio.subspan(x));
}

STOF_INSTANTIATE(PeakRatio, peak_ratio, std::uint8_t, std::uint16_t, std::uint32_t);

}  // namespace stof::dsp::neon
