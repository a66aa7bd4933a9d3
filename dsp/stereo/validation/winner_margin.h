#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

#include "dsp/base/fixed.h"
#include "dsp/base/image.h"
#include "dsp/base/kernel.h"
#include "dsp/stereo/search/winner.h"
#include "dsp/stereo/validation/window_sums.h"

// A match must stand out from its rivals (option `distinct`): the winner margin of Hu & Mordohai
// 2012, against the mean of all candidates in place of the second best, summed over surroundings.
// Where both pictures hold nothing but noise, the winner costs nearly as much as a candidate does
// on average (78 to 85 percent with 64 candidates), however strong the noise; on a real surface,
// even a weakly textured one, it costs half or less.
// Surroundings (24 x 24 px) whose winners cost more than a share of the mean are dropped.
namespace stof::dsp {

inline constexpr int kMarginPercent = 70;
// For costs that are means over neighbours that look alike: there noise averages out, and the
// winner costs nearer to the mean.
inline constexpr int kAdCensusMarginPercent = 80;

// percent and shift of winner_margins().
struct MarginScale {
  int percent = kMarginPercent;
  int shift = 0;
};

// The smallest shift for which no margin of costs up to `largest_cost` is clipped.
constexpr int margin_shift(std::int64_t largest_cost, int lanes) noexcept {
  int shift = 0;
  while (((100 * largest_cost * lanes) >> shift) > 32767) {
    ++shift;
  }
  return shift;
}
static_assert(margin_shift(828, 64) == 8);

// margins[x] = (percent sum - 100 count c) >> shift, clipped to +-32767: sum and count of the
// candidates that have a cost, c the cost of winners[x]; above 0 where the winner costs less than
// so many percent, 1..100, of the mean. 0 where there is no winner, or the winner has no cost.
// Layout as in sad.h; lanes a multiple of 16, at most 256; u32 costs below 2^29; shift in 0..30.
// `winners` may come from another search on these costs (paths); every candidate of the search
// range should have its cost here: the mean of a few candidates around the winner says nothing
// about noise.
template <typename Sum>
using WinnerMargins = void(std::span<const Sum> costs, int lanes,
                           std::span<const std::int16_t> winners, int percent, int shift,
                           std::span<std::int16_t> margins) noexcept;

STOF_KERNELS(WinnerMargins, winner_margins, Avx2<std::uint8_t>, Avx2<std::uint16_t>,
             Neon<std::uint32_t>)

// Drops the disparities of `rows` where the margins of the surroundings sum to 0 or less.
// Only `rows` of disparities are written; any split gives the same. window: scratch.
void drop_small_margins(ImageView<const std::int16_t> margins, Rows rows, WindowSums& window,
                        ImageView<Disparity> disparities) noexcept;

}  // namespace stof::dsp
