#pragma once

#include <cstdint>
#include <span>

#include "dsp/base/kernel.h"

namespace stof::dsp {

// The check of Faugeras: the match of the match must be the pixel itself. Left winner i of column x
// is kept when the right winner of its match, right_winners[n - 1 - x + i] (layout of winner.h),
// differs from i by at most `tolerance` candidates; else it becomes kNoWinner. n = winners.size();
// right_winners has at least n - 1 + i + 1 elements for every winner i.
using LeftRightCheck = void(std::span<const std::int16_t> right_winners, int tolerance,
                            std::span<std::int16_t> winners) noexcept;
STOF_KERNEL(LeftRightCheck, left_right_check, kNeon)

}  // namespace stof::dsp
