#pragma once

#include <cstdint>
#include <span>

#include "dsp/base/kernel.h"
#include "dsp/stereo/search/winner.h"

namespace stof::dsp {

// right_winners() (winner.h) of costs that are numbered_cost() (block_winners.h) each: the same
// winners, and no lowest costs. The lowest of each eighth candidate is a minimum alone, because it
// brings its group along. At most 256 lanes; winners.size() = columns + lanes - 1.
using NumberedRightWinners = void(std::span<const std::uint16_t> costs, int lanes,
                                  std::span<std::int16_t> winners) noexcept;
STOF_KERNEL(NumberedRightWinners, numbered_right_winners, kAvx512)

}  // namespace stof::dsp
