#include "dsp/stereo/search/winner.h"

#include <algorithm>
#include <array>
#include <cstddef>

#include "dsp/base/check.h"
#include "dsp/base/simd.h"
#include "dsp/stereo/cost/sums_neon.h"

namespace stof::dsp::neon {
namespace {

constexpr std::array<std::uint32_t, 8> kCount{0, 1, 2, 3, 4, 5, 6, 7};

uint16x8_t first_lanes(uint16x8_t /*kind*/) noexcept {
  return vcombine_u16(vmovn_u32(vld1q_u32(kCount.data())), vmovn_u32(vld1q_u32(kCount.data() + 4)));
}
uint32x4_t first_lanes(uint32x4_t /*kind*/) noexcept { return vld1q_u32(kCount.data()); }

template <typename Sum>
std::int16_t find_winner(const Sum* costs, std::size_t lanes) noexcept {
  using V = typename Vector<Sum>::type;
  constexpr std::size_t kStep = Vector<Sum>::kLanes;
  const V one = all(Sum{1});
  V lowest = load(costs);
  V highest = add(lowest, one);  // of cost + 1, which wraps to 0 for kNoCost
  V candidate = first_lanes(lowest);
  V best = candidate;
  for (std::size_t i = kStep; i < lanes; i += kStep) {
    candidate = add(candidate, all(static_cast<Sum>(kStep)));
    const V cost = load(costs + i);
    const V better = less(cost, lowest);
    best = select(better, candidate, best);
    lowest = smaller(lowest, cost);
    highest = larger(highest, add(cost, one));
  }
  const Sum minimum = smallest(lowest);
  if (minimum == kNoCost<Sum> || largest(highest) == static_cast<Sum>(minimum + 1)) {
    return kNoWinner;
  }
  return static_cast<std::int16_t>(
      smallest(select(equal(lowest, all(minimum)), best, all(kNoCost<Sum>))));
}

template <typename Sum>
void find_winners(std::span<const Sum> costs, int lanes, std::span<std::int16_t> winners) noexcept {
  const std::size_t count = static_cast<std::size_t>(lanes);
  STOF_CHECK(lanes >= kCostLanes && lanes % kCostLanes == 0 &&
             costs.size() == winners.size() * count);
  for (std::size_t x = 0; x < winners.size(); ++x) {
    winners[x] = find_winner(costs.data() + x * count, count);
  }
}

// Eight candidates at position j: both the sums and the 16-bit winners.
void improve(const std::uint16_t* costs, std::uint16_t* lowest, std::int16_t* winners,
             uint16x8_t candidate) noexcept {
  const uint16x8_t cost = vld1q_u16(costs);
  const uint16x8_t old = vld1q_u16(lowest);
  const uint16x8_t better = vcltq_u16(cost, old);
  vst1q_u16(lowest, vminq_u16(cost, old));
  vst1q_s16(winners, vbslq_s16(better, vreinterpretq_s16_u16(candidate), vld1q_s16(winners)));
}
void improve(const std::uint32_t* costs, std::uint32_t* lowest, std::int16_t* winners,
             uint16x8_t candidate) noexcept {
  const uint32x4_t low = vld1q_u32(costs);
  const uint32x4_t high = vld1q_u32(costs + 4);
  const uint32x4_t old_low = vld1q_u32(lowest);
  const uint32x4_t old_high = vld1q_u32(lowest + 4);
  const uint16x8_t better =
      vcombine_u16(vmovn_u32(vcltq_u32(low, old_low)), vmovn_u32(vcltq_u32(high, old_high)));
  vst1q_u32(lowest, vminq_u32(low, old_low));
  vst1q_u32(lowest + 4, vminq_u32(high, old_high));
  vst1q_s16(winners, vbslq_s16(better, vreinterpretq_s16_u16(candidate), vld1q_s16(winners)));
}

template <typename Sum>
void find_right_winners(std::span<const Sum> costs, int lanes, std::span<Sum> lowest,
                        std::span<std::int16_t> winners) noexcept {
  const std::size_t count = static_cast<std::size_t>(lanes);
  const std::size_t n = costs.size() / count;
  STOF_CHECK(lanes >= kCostLanes && lanes % kCostLanes == 0 && costs.size() == n * count);
  STOF_CHECK(lowest.size() == n + count - 1 && winners.size() == lowest.size());
  std::ranges::fill(lowest, kNoCost<Sum>);
  std::ranges::fill(winners, kNoWinner);
  const uint16x8_t first = first_lanes(uint16x8_t{});
  for (std::size_t x = 0; x < n; ++x) {
    const Sum* const pixel = costs.data() + x * count;
    const std::size_t j = n - 1 - x;
    uint16x8_t candidate = first;
    for (std::size_t i = 0; i < count; i += 8) {
      improve(pixel + i, lowest.data() + j + i, winners.data() + j + i, candidate);
      candidate = vaddq_u16(candidate, vdupq_n_u16(8));
    }
  }
}

}  // namespace

void winners(std::span<const std::uint16_t> costs, int lanes,
             std::span<std::int16_t> out) noexcept {
  find_winners(costs, lanes, out);
}
void winners(std::span<const std::uint32_t> costs, int lanes,
             std::span<std::int16_t> out) noexcept {
  find_winners(costs, lanes, out);
}
void right_winners(std::span<const std::uint16_t> costs, int lanes, std::span<std::uint16_t> lowest,
                   std::span<std::int16_t> out) noexcept {
  find_right_winners(costs, lanes, lowest, out);
}
void right_winners(std::span<const std::uint32_t> costs, int lanes, std::span<std::uint32_t> lowest,
                   std::span<std::int16_t> out) noexcept {
  find_right_winners(costs, lanes, lowest, out);
}

}  // namespace stof::dsp::neon
