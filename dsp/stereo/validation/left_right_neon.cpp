#include "dsp/stereo/validation/left_right.h"

#include <algorithm>
#include <cstddef>
#include <limits>

#include "dsp/base/check.h"
#include "dsp/base/simd.h"
#include "dsp/stereo/search/winner.h"

namespace stof::dsp::neon {
namespace {

constexpr std::int16_t kLanes[8] = {0, 1, 2, 3, 4, 5, 6, 7};

// The right winners at eight places.
template <int kLane>
int16x8_t gather(const std::int16_t* from, int16x8_t places, int16x8_t result) noexcept {
  if constexpr (kLane == 8) {
    return result;
  } else {
    const std::int16_t* const match = from + vgetq_lane_s16(places, kLane);
    return gather<kLane + 1>(from, places, vld1q_lane_s16(match, result, kLane));
  }
}

}  // namespace

void left_right_check(std::span<const std::int16_t> right_winners, int tolerance,
                      std::span<std::int16_t> winners) noexcept {
  STOF_CHECK(tolerance >= 0 && right_winners.size() >= winners.size());
  const std::size_t n = winners.size();
  const int16x8_t none = vdupq_n_s16(kNoWinner);
  const int limit = std::min<int>(tolerance, std::numeric_limits<std::int16_t>::max());
  const int16x8_t largest = vdupq_n_s16(static_cast<std::int16_t>(limit));
  std::size_t x = 0;
  for (; x + 8 <= n; x += 8) {
    const int16x8_t winner = vld1q_s16(winners.data() + x);
    // Pixels without a winner read candidate 0, harmlessly.
    const int16x8_t places = vsubq_s16(vmaxq_s16(winner, vdupq_n_s16(0)), vld1q_s16(kLanes));
    const int16x8_t back = gather<0>(right_winners.data() + (n - 1 - x), places, vdupq_n_s16(0));
    const uint16x8_t near = vcleq_s16(vabdq_s16(back, winner), largest);
    const uint16x8_t keep = vbicq_u16(near, vceqq_s16(back, none));
    vst1q_s16(winners.data() + x, vbslq_s16(keep, winner, none));
  }
  if (x < n) {
    // The last pixels are those of a shorter row: their matches stand at the same places.
    ref::left_right_check(right_winners, tolerance, winners.subspan(x));
  }
}

}  // namespace stof::dsp::neon
