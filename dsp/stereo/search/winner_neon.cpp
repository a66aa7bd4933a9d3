#include "dsp/stereo/search/winner.h"

#include <algorithm>
#include <cstddef>

#include "dsp/base/check.h"
#include "dsp/base/lanes_neon.h"
#include "dsp/base/mutation.h"

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

void store_last(std::uint8_t* to, uint8x16_t v) noexcept { vst1q_lane_u8(to, v, 15); }
void store_last(std::uint16_t* to, uint16x8_t v) noexcept { vst1q_lane_u16(to, v, 7); }

// The right pixels that one column's candidates meet move by one from column to column. A window of
// them, kVectors vectors from candidate `first` on, stays in registers: one pixel enters it with
// what smaller candidates left behind, one leaves it. (In memory each column would wait for the
// stores of the one before.)
template <typename Sum, std::size_t kVectors>
void scan_window(std::span<const Sum> costs, std::size_t lanes, std::size_t first, Sum* lowest,
                 Sum* best) noexcept {
  using L = Lanes<Sum>;
  using V = typename L::V;
  constexpr std::size_t kStep = L::kLanes;
  constexpr std::size_t kLast = kVectors * kStep - 1;
  const std::size_t n = costs.size() / lanes;
  V low[kVectors];
  V win[kVectors];
  V candidates[kVectors];
  for (std::size_t v = 0; v < kVectors; ++v) {
    low[v] = L::load(lowest + n - 1 + first + v * kStep);
    win[v] = L::load(best + n - 1 + first + v * kStep);
    candidates[v] = L::numbers() + L::all(static_cast<Sum>(first + v * kStep));
  }
  for (std::size_t x = 0; x < n; ++x) {
    const std::size_t j = n - 1 - x + first;
    if (x > 0) {
      for (std::size_t v = kVectors - 1; v > 0; --v) {
        low[v] = L::one_up(low[v - 1], low[v]);
        win[v] = L::one_up(win[v - 1], win[v]);
      }
      low[0] = L::one_up(L::all(lowest[j]), low[0]);
      win[0] = L::one_up(L::all(best[j]), win[0]);
    }
    for (std::size_t v = 0; v < kVectors; ++v) {
      const V cost = L::load(costs.data() + x * lanes + first + v * kStep);
      win[v] = L::select(L::less(cost, low[v]), candidates[v], win[v]);
      low[v] = L::smaller(low[v], cost);
    }
    store_last(lowest + j + kLast, low[kVectors - 1]);
    store_last(best + j + kLast, win[kVectors - 1]);
  }
  for (std::size_t v = 0; v < kVectors; ++v) {
    L::store(lowest + first + v * kStep, low[v]);
    L::store(best + first + v * kStep, win[v]);
  }
}

// best: candidates, as far as lowest is not kNoCost.
template <typename Sum>
void scan_windows(std::span<const Sum> costs, std::size_t lanes, std::span<Sum> lowest,
                  Sum* best) noexcept {
  constexpr std::size_t kStep = Lanes<Sum>::kLanes;
  std::ranges::fill(lowest, kNoCost<Sum>);
  std::size_t first = 0;
  for (; first + 4 * kStep <= lanes; first += 4 * kStep) {
    scan_window<Sum, 4>(costs, lanes, first, lowest.data(), best);
  }
  for (; first < lanes; first += kStep) {
    scan_window<Sum, 1>(costs, lanes, first, lowest.data(), best);
  }
}

void find_right_winners(std::span<const std::uint16_t> costs, std::size_t lanes,
                        std::span<std::uint16_t> lowest, std::span<std::int16_t> winners) noexcept {
  auto* const best = reinterpret_cast<std::uint16_t*>(winners.data());  // NOLINT: the same numbers
  std::ranges::fill(winners, kNoWinner);
  scan_windows(costs, lanes, lowest, best);
}

// Candidates fit bytes too: those are the second half of the winners' own memory until they become
// winners in place.
void find_right_winners(std::span<const std::uint8_t> costs, std::size_t lanes,
                        std::span<std::uint8_t> lowest, std::span<std::int16_t> winners) noexcept {
  const std::span<std::byte> memory = std::as_writable_bytes(winners).last(winners.size());
  auto* const best = reinterpret_cast<std::uint8_t*>(memory.data());  // NOLINT: bytes are bytes
  std::ranges::fill(memory, std::byte{0});
  scan_windows(costs, lanes, lowest, best);
  for (std::size_t j = 0; j < winners.size(); ++j) {
    const std::int16_t candidate = best[j];
    winners[j] = lowest[j] == kNoCost<std::uint8_t> ? kNoWinner : candidate;
  }
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
