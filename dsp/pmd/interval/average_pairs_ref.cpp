#include "dsp/pmd/interval/average_pairs.h"

#include <algorithm>
#include <cstddef>
#include <cstdlib>

#include "dsp/base/check.h"

namespace stof::dsp::ref {
namespace {

constexpr int kSlopeBits = 16;
constexpr int kShareBits = 15;

struct Reading {
  int distance;
  int sigma;
  bool there() const noexcept { return distance != kNoDepth && sigma <= kMaxAveragedSigma; }
};

}  // namespace

void average_pairs(const IntervalRows& rows, std::uint16_t slope_q16,
                   std::span<QuarterMm> out_distance, std::span<QuarterMm> out_sigma) noexcept {
  const std::size_t n = out_distance.size();
  STOF_CHECK(out_sigma.size() == n);
  const std::array distances{rows.distance_above, rows.distance_here, rows.distance_below};
  const std::array sigmas{rows.sigma_above, rows.sigma_here, rows.sigma_below};
  for (std::size_t k = 0; k < 3; ++k) {
    STOF_CHECK(distances[k].size() == n + 2 && sigmas[k].size() == n + 2);
  }
  for (std::size_t x = 0; x < n; ++x) {
    // Of the 3x3 neighbours the k-th, row by row; 8 - k lies opposite.
    const auto reading = [&](std::size_t k) noexcept {
      return Reading{distances[k / 3][x + k % 3], sigmas[k / 3][x + k % 3]};
    };
    const Reading here = reading(4);
    out_distance[x] = static_cast<QuarterMm>(here.distance);
    out_sigma[x] = static_cast<QuarterMm>(here.distance == kNoDepth ? 0 : here.sigma);
    if (!here.there()) {
      continue;
    }
    const int slope = static_cast<int>((std::int64_t{here.distance} * slope_q16) >> kSlopeBits);
    std::size_t pairs = 0;
    int pull = 0;
    int noises = 0;
    for (std::size_t k = 0; k < 4; ++k) {
      const Reading a = reading(k);
      const Reading b = reading(8 - k);
      const int mean = (a.distance + b.distance + 1) / 2;
      const int noise = (a.sigma + b.sigma + 1) / 2;
      const int reach = std::min<int>(2 * here.sigma + noise, kMaxPull);
      if (a.there() && b.there() && std::abs(mean - here.distance) <= reach &&
          std::abs(a.distance - b.distance) <= 6 * noise + slope) {
        ++pairs;
        pull += mean - here.distance;
        noises += noise;
      }
    }
    if (pairs == 0) {
      continue;
    }
    const int sum = here.sigma + 2 * noises;
    const int mean = round_shift(sum * kPairShare[pairs], kShareBits + 1);
    const int sigma = round_shift(mean * kSmoothShare[pairs], kShareBits);
    out_distance[x] =
        static_cast<QuarterMm>(here.distance + round_shift(pull * kPairShare[pairs], kShareBits));
    out_sigma[x] = static_cast<QuarterMm>(std::max(std::min(here.sigma, sigma), 1));
  }
}

}  // namespace stof::dsp::ref
