#include "dsp/stereo/search/winner.h"

#include <algorithm>
#include <cstddef>

#include "dsp/base/check.h"
#include "dsp/base/lanes_neon.h"
#include "dsp/base/mutation.h"
#include "dsp/stereo/search/right_winners_body.h"

namespace stof::dsp::neon {
namespace {

template <typename Sum>
std::int16_t find_winner(const Sum* costs, std::size_t lanes) noexcept {
  using L = Lanes<Sum>;
  using V = typename L::V;
  const V one = L::all(1);
  V lowest = L::load(costs);
  V highest = lowest + one;  // of cost + 1, which wraps to 0 for kNoCost
  V candidate = L::numbers();
  V best = candidate;
  for (std::size_t i = L::kLanes; i < lanes; i += L::kLanes) {
    candidate = candidate + L::all(L::kLanes);
    const V cost = L::load(costs + i);
    const V better = L::less(cost, lowest);
    best = L::select(better, candidate, best);
    lowest = L::smaller(lowest, cost);
    highest = L::larger(highest, cost + one);
  }
  const Sum minimum = L::smallest(lowest);
  if (minimum == kNoCost<Sum> || L::largest(highest) == static_cast<Sum>(minimum + 1)) {
    return kNoWinner;
  }
  return static_cast<std::int16_t>(
      L::smallest(L::select(L::equal(lowest, L::all(minimum)), best, L::all(kNoCost<Sum>))));
}

// Eight candidates at position j: both the sums and the 16-bit winners.
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

void find_right_winners(std::span<const std::uint32_t> costs, std::size_t lanes,
                        std::span<std::uint32_t> lowest, std::span<std::int16_t> winners) noexcept {
  const std::size_t n = costs.size() / lanes;
  std::ranges::fill(lowest, kNoCost<std::uint32_t>);
  std::ranges::fill(winners, kNoWinner);
  const uint16x8_t first = Lanes<std::uint16_t>::numbers();
  for (std::size_t x = 0; x < n; ++x) {
    const std::uint32_t* const pixel = costs.data() + x * lanes;
    const std::size_t j = n - 1 - x;
    uint16x8_t candidate = first;
    for (std::size_t i = 0; i < lanes; i += 8) {
      improve(pixel + i, lowest.data() + j + i, winners.data() + j + i, candidate);
      candidate = vaddq_u16(candidate, vdupq_n_u16(8));
    }
  }
}

// kNoWinner where missing.
void store_winners(uint8x16_t candidates, uint8x16_t missing, std::int16_t* winners) noexcept {
  const int8x16_t none = vreinterpretq_s8_u8(missing);  // all ones stay all ones
  const auto widened = [](uint8x8_t half, int8x8_t none_of) noexcept {
    return vorrq_s16(vreinterpretq_s16_u16(vmovl_u8(half)), vmovl_s8(none_of));
  };
  vst1q_s16(winners, widened(vget_low_u8(candidates), vget_low_s8(none)));
  vst1q_s16(winners + 8, widened(vget_high_u8(candidates), vget_high_s8(none)));
}
void store_winners(uint16x8_t candidates, uint16x8_t missing, std::int16_t* winners) noexcept {
  vst1q_s16(winners, vreinterpretq_s16_u16(vorrq_u16(candidates, missing)));
}

template <typename Sum>
struct RightLanes : Lanes<Sum> {
  using L = Lanes<Sum>;
  using V = typename L::V;

  static V either(V a, V b) noexcept { return a | b; }
  static V next(V v) noexcept { return v + L::all(1); }
  static void meet(V costs, V candidate, V& lowest, V& winner) noexcept {
    winner = L::select(L::less(costs, lowest), candidate, winner);
    lowest = L::smaller(lowest, costs);
  }
  static void meet_all(const Sum* column, std::ptrdiff_t lanes, V& lowest, V& winner) noexcept {
    constexpr int kCount = static_cast<int>(L::kLanes);
    V first = L::numbers() - L::all(kCount);  // of eight candidates
    const Sum* at = column - kCount * lanes;
    meet_eights<Part::kBegin>(at, lanes, first, lowest, winner);
    for (at = column; at < column + (lanes - kCount) * (lanes + 1); at += 8 * (lanes + 1)) {
      meet_eight<Part::kMiddle, 0>(at, lanes + 1, first, lowest, winner);
    }
    meet_eights<Part::kEnd>(at, lanes, first, lowest, winner);
  }
  static void store(V lowest, V winner, Sum* to_lowest, std::int16_t* to_winners) noexcept {
    L::store(to_lowest, lowest);
    store_winners(winner, L::equal(lowest, L::all(kNoCost<Sum>)), to_winners);
  }

 private:
  enum class Part : std::uint8_t { kBegin, kMiddle, kEnd };

  // Of a vector that begins before the candidates of a column, or ends behind them, the rest:
  // all but the first kShift lanes are what a column begins with, or all but the last ones what it
  // ends with.
  template <Part kPart, int kShift>
  static V costs_at(const Sum* at) noexcept {
    const V costs = L::load(at);
    if constexpr (kPart == Part::kBegin) {
      return L::template joined<kShift>(L::all(kNoCost<Sum>), costs);
    } else if constexpr (kPart == Part::kEnd) {
      return L::template joined<kShift>(costs, L::all(kNoCost<Sum>));
    } else {
      return costs;
    }
  }

  // The kLanes candidates of which not all pixels have each.
  template <Part kPart>
  static void meet_eights(const Sum*& at, std::ptrdiff_t lanes, V& first, V& lowest,
                          V& winner) noexcept {
    meet_eight<kPart, 0>(at, lanes, first, lowest, winner);
    at += 8 * lanes;
    if constexpr (L::kLanes == 16) {
      meet_eight<kPart, 8>(at, lanes, first, lowest, winner);
      at += 8 * lanes;
    }
  }

  // Eight candidates: winners are numbered within them first, and these numbers stay in registers.
  template <Part kPart, int kShift>
  static void meet_eight(const Sum* at, std::ptrdiff_t step, V& first, V& lowest,
                         V& winner) noexcept {
    const V before = lowest;
    V number = L::all(0);
    lowest = L::smaller(lowest, costs_at<kPart, kShift>(at));
    meet_next<kPart, kShift + 1, 1>(at + step, lowest, number);
    meet_next<kPart, kShift + 2, 2>(at + 2 * step, lowest, number);
    meet_next<kPart, kShift + 3, 3>(at + 3 * step, lowest, number);
    meet_next<kPart, kShift + 4, 4>(at + 4 * step, lowest, number);
    meet_next<kPart, kShift + 5, 5>(at + 5 * step, lowest, number);
    meet_next<kPart, kShift + 6, 6>(at + 6 * step, lowest, number);
    meet_next<kPart, kShift + 7, 7>(at + 7 * step, lowest, number);
    winner = L::select(L::less(lowest, before), first + number, winner);
    first = first + L::all(8);
  }
  template <Part kPart, int kShift, Sum kNumber>
  static void meet_next(const Sum* at, V& lowest, V& number) noexcept {
    const V costs = costs_at<kPart, kShift>(at);
    number = L::select(L::less(costs, lowest), L::all(kNumber), number);
    lowest = L::smaller(lowest, costs);
  }
};

template <typename Sum>
void find_right_winners(std::span<const Sum> costs, std::size_t lanes, std::span<Sum> lowest,
                        std::span<std::int16_t> winners) noexcept {
  right_winners_body::find<RightLanes<Sum>>(costs, static_cast<int>(lanes), lowest, winners);
  mutate(winners);
}

}  // namespace

template <typename Sum>
void winners(std::span<const Sum> costs, int lanes, std::span<std::int16_t> winners) noexcept {
  const std::size_t count = static_cast<std::size_t>(lanes);
  STOF_CHECK(lanes >= kCostLanes && lanes % kCostLanes == 0 &&
             costs.size() == winners.size() * count);
  for (std::size_t x = 0; x < winners.size(); ++x) {
    winners[x] = find_winner(costs.data() + x * count, count);
  }
  mutate(winners);
}

template <typename Sum>
void right_winners(std::span<const Sum> costs, int lanes, std::span<Sum> lowest,
                   std::span<std::int16_t> winners) noexcept {
  const std::size_t count = static_cast<std::size_t>(lanes);
  const std::size_t n = costs.size() / count;
  STOF_CHECK(lanes >= kCostLanes && lanes % kCostLanes == 0 && costs.size() == n * count);
  STOF_CHECK(n >= 1 && lowest.size() == n + count - 1 && winners.size() == lowest.size());
  find_right_winners(costs, count, lowest, winners);
}

STOF_INSTANTIATE(Winners, winners, std::uint8_t, std::uint16_t, std::uint32_t);
STOF_INSTANTIATE(RightWinners, right_winners, std::uint8_t, std::uint16_t, std::uint32_t);

}  // namespace stof::dsp::neon
