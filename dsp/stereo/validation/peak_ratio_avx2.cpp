#include "dsp/stereo/validation/peak_ratio.h"

#include <array>
#include <cstddef>

#include "dsp/base/check.h"
#include "dsp/base/lanes_avx2.h"
#include "dsp/base/mutation.h"
#include "dsp/stereo/cost/sad.h"
#include "dsp/stereo/search/winner.h"

namespace stof::dsp::avx2 {
namespace {

constexpr std::size_t kAtOnce = 8;
constexpr std::size_t kMostLanes = 256;

// Read from kNear<Sum> + kMostLanes - i on, lane k is all ones where |k - i| <= 1.
template <typename Sum>
constexpr auto kNear = [] {
  std::array<Sum, 2 * kMostLanes + 1> near{};
  near[kMostLanes - 1] = near[kMostLanes] = near[kMostLanes + 1] = kNoCost<Sum>;
  return near;
}();

// The lowest of the costs that are not near the winner's.
template <typename V, typename Sum>
Sum best_rival(const Sum* costs, std::size_t lanes, std::int16_t winner) noexcept {
  constexpr std::size_t kLanes = sizeof(V) / sizeof(Sum);
  const Sum* const near = kNear<Sum>.data() + kMostLanes - winner;
  V least = all(kNoCost<Sum>);
  for (std::size_t i = 0; i < lanes; i += kLanes) {
    least = smaller(least, load<V>(costs + i) | load<V>(near + i));
  }
  return Lanes<Sum>::lowest(least)[0];
}

// floor(255 cost / rival), or 255 where cost >= rival.
i32x8 quotient(i32x8 cost, i32x8 rival) noexcept {
  const __m256 scaled = _mm256_mul_ps(_mm256_set1_ps(255.0F), _mm256_cvtepi32_ps(bits(cost)));
  const __m256 ratio = _mm256_div_ps(scaled, _mm256_cvtepi32_ps(bits(rival)));
  return cost >= rival ? all(std::int32_t{255}) : as<i32x8>(_mm256_cvttps_epi32(ratio));
}

}  // namespace

template <typename Sum>
void peak_ratio(std::span<const Sum> costs, int lanes, std::span<const std::int16_t> winners,
                std::span<std::uint8_t> ratio) noexcept {
  if (lanes % static_cast<int>(Lanes<Sum>::kLanes) != 0) {
    neon::peak_ratio(costs, lanes, winners, ratio);
    return;
  }
  using V = typename VectorOf<Sum>::type;
  const std::size_t count = static_cast<std::size_t>(lanes);
  STOF_CHECK(lanes > 0 && lanes <= 256 && costs.size() == winners.size() * count &&
             ratio.size() == winners.size());
  std::size_t x = 0;
  for (; x + kAtOnce <= ratio.size(); x += kAtOnce) {
    // Nothing known: cost 1 and rival 1.
    std::array<std::int32_t, kAtOnce> cost{};
    std::array<std::int32_t, kAtOnce> rival{};
    for (std::size_t k = 0; k < kAtOnce; ++k) {
      const std::int16_t winner = winners[x + k];
      const Sum* const pixel = costs.data() + (x + k) * count;
      const Sum own = winner == kNoWinner ? kNoCost<Sum> : pixel[winner];
      const Sum other = own == kNoCost<Sum> ? own : best_rival<V>(pixel, count, winner);
      cost[k] = other == kNoCost<Sum> ? 1 : own;
      rival[k] = other == kNoCost<Sum> ? 1 : other;
    }
    const i32x8 result = quotient(load<i32x8>(cost.data()), load<i32x8>(rival.data()));
    for (std::size_t k = 0; k < kAtOnce; ++k) {
      ratio[x + k] = static_cast<std::uint8_t>(result[k]);
    }
  }
  mutate(ratio.first(x));
  neon::peak_ratio(costs.subspan(x * count), lanes, winners.subspan(x), ratio.subspan(x));
}

STOF_INSTANTIATE(PeakRatio, peak_ratio, std::uint8_t, std::uint16_t);

}  // namespace stof::dsp::avx2
