#include "dsp/stereo/validation/winner_margin.h"

#include <algorithm>
#include <cstddef>

#include "dsp/base/avx2.h"
#include "dsp/base/check.h"
#include "dsp/base/mutation.h"

namespace stof::dsp::avx2 {
namespace {

// Costs of those that have one.
struct Offered {
  std::int64_t sum;
  std::int64_t count;
};

// Costs and missing ones are added up in the lower and upper halves of 64 bits.
Offered offered(const std::uint8_t* costs, std::size_t lanes) noexcept {
  u8x32 missing{};
  __m256i sums = _mm256_setzero_si256();
  for (std::size_t i = 0; i < lanes; i += 32) {
    const u8x32 cost = load<u8x32>(costs + i);
    missing -= as<u8x32>(bits(cost == all(kNoCost<std::uint8_t>)));
    sums = _mm256_add_epi64(sums, _mm256_sad_epu8(bits(cost), _mm256_setzero_si256()));
  }
  const __m256i counts = _mm256_sad_epu8(bits(missing), _mm256_setzero_si256());
  const __m256i quarters = _mm256_add_epi64(sums, _mm256_slli_epi64(counts, 32));
  const __m128i half =
      _mm_add_epi64(_mm256_castsi256_si128(quarters), _mm256_extracti128_si256(quarters, 1));
  const std::int64_t both = _mm_cvtsi128_si64(_mm_add_epi64(half, _mm_unpackhi_epi64(half, half)));
  const std::int64_t without = both >> 32;
  return {.sum = (both & 0xFFFFFFFF) - without * kNoCost<std::uint8_t>,
          .count = static_cast<std::int64_t>(lanes) - without};
}

// Costs less 32768, which products add up in pairs.
Offered offered(const std::uint16_t* costs, std::size_t lanes) noexcept {
  constexpr std::uint16_t kMiddle = 32768;
  const __m256i one = _mm256_set1_epi16(1);
  u16x16 missing{};  // their number, negative
  __m256i sums = _mm256_setzero_si256();
  for (std::size_t i = 0; i < lanes; i += 16) {
    const u16x16 cost = load<u16x16>(costs + i);
    missing += as<u16x16>(bits(cost == all(kNoCost<std::uint16_t>)));
    sums = _mm256_add_epi32(sums, _mm256_madd_epi16(bits(cost ^ all(kMiddle)), one));
  }
  const __m256i pairs = _mm256_hadd_epi32(sums, _mm256_madd_epi16(bits(missing), one));
  const __m128i half =
      _mm_add_epi32(_mm256_castsi256_si128(pairs), _mm256_extracti128_si256(pairs, 1));
  const auto both = _mm_cvtsi128_si64(_mm_hadd_epi32(half, half));
  const auto sum = static_cast<std::int32_t>(both);
  const auto every = static_cast<std::int64_t>(lanes);
  const std::int64_t without = -(both >> 32);
  return {.sum = sum + every * kMiddle - without * kNoCost<std::uint16_t>,
          .count = every - without};
}

// kLanes as many as there are, or 0: a known count is unrolled.
template <std::size_t kLanes, typename Sum>
void find_margins_of(std::span<const Sum> costs, std::size_t lanes,
                     std::span<const std::int16_t> winners, int percent, int shift,
                     std::span<std::int16_t> margins) noexcept {
  const std::size_t count = kLanes != 0 ? kLanes : lanes;
  const Sum* pixel = costs.data();
  for (std::size_t x = 0; x < winners.size(); ++x) {
    const std::int16_t winner = winners[x];
    std::int64_t lead = 0;
    if (winner != kNoWinner && pixel[winner] != kNoCost<Sum>) {
      const Offered all_costs = offered(pixel, count);
      lead = percent * all_costs.sum - 100 * all_costs.count * pixel[winner];
    }
    margins[x] = static_cast<std::int16_t>(std::clamp<std::int64_t>(lead >> shift, -32767, 32767));
    pixel += count;
  }
}

}  // namespace

template <typename Sum>
void winner_margins(std::span<const Sum> costs, int lanes, std::span<const std::int16_t> winners,
                    int percent, int shift, std::span<std::int16_t> margins) noexcept {
  if (lanes % static_cast<int>(32 / sizeof(Sum)) != 0) {
    neon::winner_margins(costs, lanes, winners, percent, shift, margins);
    return;
  }
  const std::size_t count = static_cast<std::size_t>(lanes);
  const std::size_t n = winners.size();
  STOF_CHECK(lanes > 0 && lanes <= 256 && shift >= 0 && shift <= 30 && costs.size() == n * count &&
             margins.size() == n);
  if (lanes == 64) {
    find_margins_of<64>(costs, count, winners, percent, shift, margins);
  } else {
    find_margins_of<0>(costs, count, winners, percent, shift, margins);
  }
  mutate(margins);
}

STOF_INSTANTIATE(WinnerMargins, winner_margins, std::uint8_t, std::uint16_t);

}  // namespace stof::dsp::avx2
