#include "dsp/pmd/interval/interval.h"

#include <algorithm>
#include <array>
#include <cstddef>

#include "dsp/base/check.h"
#include "dsp/pmd/pmd_maps.h"

namespace stof::dsp::ref {
namespace {

struct Reading {
  int distance;
  int sigma;
  friend constexpr auto operator<=>(const Reading&, const Reading&) noexcept = default;
};

unsigned flag_if(bool condition, PmdFlag flag) noexcept { return condition ? unsigned{flag} : 0; }

constexpr int kSlopeBits = 16;

}  // namespace

void interval(const IntervalRows& rows, const IntervalLimits& limits, std::span<std::uint8_t> flags,
              std::span<QuarterMm> low, std::span<QuarterMm> high) noexcept {
  const std::size_t n = flags.size();
  STOF_CHECK(low.size() == n && high.size() == n);
  const std::array distances{rows.distance_above, rows.distance_here, rows.distance_below};
  const std::array sigmas{rows.sigma_above, rows.sigma_here, rows.sigma_below};
  for (std::size_t k = 0; k < 3; ++k) {
    STOF_CHECK(distances[k].size() == n + 2 && sigmas[k].size() == n + 2);
  }
  for (std::size_t x = 0; x < n; ++x) {
    low[x] = kNoDepth;
    high[x] = kNoDepth;
    if (rows.distance_here[x + 1] == kNoDepth) {
      continue;
    }
    Reading nearest{rows.distance_here[x + 1], rows.sigma_here[x + 1]};
    Reading farthest = nearest;
    for (std::size_t k = 0; k < 9; ++k) {
      const Reading reading{distances[k / 3][x + k % 3], sigmas[k / 3][x + k % 3]};
      if (reading.distance != kNoDepth) {
        nearest = std::min(nearest, reading);
        farthest = std::max(farthest, reading);
      }
    }
    const int lo = nearest.distance - 2 * nearest.sigma;
    const int hi = std::min<int>(farthest.distance + 2 * farthest.sigma, kMaxQuarterMm);
    unsigned flag = flags[x];
    const int noise = std::min<int>(3 * nearest.sigma + 3 * farthest.sigma, kMaxQuarterMm);
    const std::int64_t slope = (std::int64_t{nearest.distance} * limits.slope_q16) >> kSlopeBits;
    flag |= flag_if(farthest.distance - nearest.distance > noise + slope, kPmdEdge);
    const bool beyond = hi > limits.range && rows.distance_here[x + 1] <= limits.range;
    flag |= flag_if(beyond || hi == kMaxQuarterMm, kPmdOutOfRange);
    if (lo <= 0 || hi - lo > limits.widest) {
      flag |= kPmdWrapped;
    } else {
      low[x] = static_cast<QuarterMm>(lo);
      high[x] = static_cast<QuarterMm>(hi);
    }
    flags[x] = static_cast<std::uint8_t>(flag);
  }
}

}  // namespace stof::dsp::ref
