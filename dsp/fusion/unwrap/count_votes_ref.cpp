#include "dsp/fusion/unwrap/count_votes.h"

#include <algorithm>
#include <cstddef>

#include "dsp/base/check.h"
#include "dsp/fusion/project/project.h"

namespace stof::dsp::ref {
namespace {

// First of the kWindow samples along an axis whose middle is nearest to a place.
int first_sample(std::int32_t place, int step_bits, int count) noexcept {
  const int step = kPositionOne << step_bits;
  const int first = (place - step - step / 2) >> (kPositionBits + step_bits);
  return std::clamp(first, -kGridBorder, count);
}

Votes count(const SampleGrid& grid, std::ptrdiff_t first, int depth, int tolerance,
            int far_off) noexcept {
  int known = 0;
  int agree = 0;
  int apart = 0;
  for (int j = 0; j < kWindow; ++j) {
    for (int i = 0; i < kWindow; ++i) {
      const std::ptrdiff_t at = first + j * grid.stride + i;
      const int low = grid.low[at];
      const int high = grid.high[at];
      const bool is_known = high != 0;
      const bool agrees = low <= std::min<int>(depth + tolerance, kMaxQuarterMm) &&
                          high >= std::max(depth - tolerance, 1);
      const bool lies_apart = is_known && (low > std::min<int>(depth + far_off, kMaxQuarterMm) ||
                                           high < std::max(depth - far_off, 0));
      known += is_known ? 1 : 0;
      agree += agrees ? 1 : 0;
      apart += lies_apart ? 1 : 0;
    }
  }
  return {static_cast<std::uint16_t>(known + Votes::kField * (agree + Votes::kField * apart))};
}

}  // namespace

void count_votes(const Places& places, const SampleGrid& grid, QuarterMm far_off,
                 std::span<Votes> votes) noexcept {
  const std::size_t n = votes.size();
  STOF_CHECK(places.u.size() == n && places.v.size() == n && places.depth.size() == n &&
             places.tolerance.size() == n);
  for (std::size_t x = 0; x < n; ++x) {
    const int i = first_sample(places.u[x], grid.step_bits, grid.columns);
    const int j = first_sample(places.v[x], grid.step_bits, grid.rows);
    votes[x] = places.depth[x] == kNoDepth ? Votes{}
                                           : count(grid, j * grid.stride + i, places.depth[x],
                                                   places.tolerance[x], far_off);
  }
}

}  // namespace stof::dsp::ref
