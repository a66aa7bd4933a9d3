#include "dsp/stereo/search/winner.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>

#include "dsp/base/check.h"
#include "dsp/base/lanes_avx2.h"
#include "dsp/stereo/search/right_winners_body.h"

namespace stof::dsp::avx2 {
namespace {

// Packs two halves by themselves.
u8x32 narrowed(u16x16 low, u16x16 high) noexcept {
  const __m256i packed = _mm256_packs_epi16(bits(low), bits(high));
  return as<u8x32>(_mm256_permute4x64_epi64(packed, 0b11'01'10'00));
}

// A bit for each of 32 candidates, set where it costs the lowest. Of `cheap` only those lanes stay
// in which that, or nothing, is asked.
std::uint64_t find_lowest(const std::uint8_t* costs, u8x32 lowest, u8x32& cheap) noexcept {
  const u8x32 cost = load<u8x32>(costs);
  const u8x32 found = as<u8x32>(bits(cost == lowest));
  cheap &= found | as<u8x32>(bits(cost == all(kNoCost<std::uint8_t>)));
  return Lanes<std::uint8_t>::mask_of(found);
}
std::uint64_t find_lowest(const std::uint16_t* costs, u16x16 lowest, u16x16& cheap) noexcept {
  const u16x16 none = all(kNoCost<std::uint16_t>);
  const u16x16 low = load<u16x16>(costs);
  const u16x16 high = load<u16x16>(costs + 16);
  const u16x16 low_found = as<u16x16>(bits(low == lowest));
  const u16x16 high_found = as<u16x16>(bits(high == lowest));
  cheap &=
      (low_found | as<u16x16>(bits(low == none))) & (high_found | as<u16x16>(bits(high == none)));
  return Lanes<std::uint8_t>::mask_of(narrowed(low_found, high_found));
}

// lanes a multiple of 32; kLanes as many, or 0: a known count is unrolled.
template <typename V, std::size_t kLanes, typename Sum>
std::int16_t find_winner(const Sum* costs, std::size_t lanes) noexcept {
  constexpr std::size_t kStep = sizeof(V) / sizeof(Sum);
  const std::size_t count = kLanes != 0 ? kLanes : lanes;
  V least = load<V>(costs);
  for (std::size_t i = kStep; i < count; i += kStep) {
    least = smaller(least, load<V>(costs + i));
  }
  const V lowest = Lanes<Sum>::lowest(least);
  V cheap = ~V{};
  std::size_t winner = 0;
  // From the last candidates to the first, which win ties.
  for (std::size_t i = count; i > 0;) {
    i -= 32;
    std::uint64_t found = find_lowest(costs + i, lowest, cheap);
    if (i > 0) {
      i -= 32;
      found = found << 32 | find_lowest(costs + i, lowest, cheap);
    }
    winner = found != 0 ? i + static_cast<std::size_t>(std::countr_zero(found)) : winner;
  }
  // Where nothing is offered, all cost the lowest.
  return Lanes<std::uint8_t>::mask_of(as<u8x32>(bits(cheap))) == ~std::uint32_t{0}
             ? kNoWinner
             : static_cast<std::int16_t>(winner);
}

template <typename V, std::size_t kLanes, typename Sum>
void find_winners_of(std::span<const Sum> costs, std::size_t lanes,
                     std::span<std::int16_t> winners) noexcept {
  const Sum* pixel = costs.data();
  for (std::int16_t& winner : winners) {
    winner = find_winner<V, kLanes>(pixel, lanes);
    pixel += lanes;
  }
}

// kNoWinner where missing.
void store_winners(u8x32 candidates, u8x32 missing, std::int16_t* winners) noexcept {
  const __m256i low = _mm256_cvtepu8_epi16(_mm256_castsi256_si128(bits(candidates)));
  const __m256i high = _mm256_cvtepu8_epi16(_mm256_extracti128_si256(bits(candidates), 1));
  const __m256i low_mask = _mm256_cvtepi8_epi16(_mm256_castsi256_si128(bits(missing)));
  const __m256i high_mask = _mm256_cvtepi8_epi16(_mm256_extracti128_si256(bits(missing), 1));
  store(winners, as<i16x16>(_mm256_or_si256(low, low_mask)));
  store(winners + 16, as<i16x16>(_mm256_or_si256(high, high_mask)));
}
void store_winners(u16x16 candidates, u16x16 missing, std::int16_t* winners) noexcept {
  store(winners, as<i16x16>(bits(candidates | missing)));
}

template <typename Sum>
struct RightLanes : Lanes<Sum> {
  using V = typename Lanes<Sum>::V;

  static V either(V a, V b) noexcept { return a | b; }
  static V next(V v) noexcept { return v + avx2::all(Sum{1}); }
  static void meet(V costs, V candidate, V& lowest, V& winner) noexcept {
    const V least = smaller(lowest, costs);
    const V kept = as<V>(bits(least == lowest));
    lowest = least;
    winner = larger(winner, candidate & ~kept);  // candidates come in ascending order
  }
  static void store(V lowest, V winner, Sum* to_lowest, std::int16_t* to_winners) noexcept {
    avx2::store(to_lowest, lowest);
    store_winners(winner, as<V>(bits(lowest == avx2::all(kNoCost<Sum>))), to_winners);
  }
};

}  // namespace

template <typename Sum>
void winners(std::span<const Sum> costs, int lanes, std::span<std::int16_t> winners) noexcept {
  using V = typename VectorOf<Sum>::type;
  if (lanes % 32 != 0) {
    neon::winners(costs, lanes, winners);
    return;
  }
  const std::size_t count = static_cast<std::size_t>(lanes);
  STOF_CHECK(lanes > 0 && costs.size() == winners.size() * count);
  if (lanes == 64) {
    find_winners_of<V, 64>(costs, count, winners);
  } else {
    find_winners_of<V, 0>(costs, count, winners);
  }
  mutate(winners);
}

template <typename Sum>
void right_winners(std::span<const Sum> costs, int lanes, std::span<Sum> lowest,
                   std::span<std::int16_t> winners) noexcept {
  if (lanes % static_cast<int>(RightLanes<Sum>::kLanes) != 0) {
    neon::right_winners(costs, lanes, lowest, winners);
    return;
  }
  right_winners_body::find<RightLanes<Sum>>(costs, lanes, lowest, winners);
}

STOF_INSTANTIATE(Winners, winners, std::uint8_t, std::uint16_t);
STOF_INSTANTIATE(RightWinners, right_winners, std::uint8_t, std::uint16_t);

}  // namespace stof::dsp::avx2
