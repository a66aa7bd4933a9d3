#pragma once

#include <cstdint>
#include <span>

#include "dsp/base/kernel.h"
#include "dsp/stereo/search/winner.h"

namespace stof::dsp {

// Winner i of cost c stays when every rival, a candidate other than i - 1, i, i + 1, costs more
// than c and at least c + percent / 100 c; else it becomes kNoWinner. Candidates without a cost are
// no rivals; a winner without a cost stays. Layout as in sad.h; lanes a multiple of 16, at most
// 256; percent in 0..1000. Works on any costs the winners were taken from, block sums or paths.
template <typename Sum>
using UniquenessCheck = void(std::span<const Sum> costs, int lanes, int percent,
                             std::span<std::int16_t> winners) noexcept;

STOF_KERNELS(UniquenessCheck, uniqueness_check, Neon<std::uint8_t>, Neon<std::uint16_t>,
             Neon<std::uint32_t>)

// Every rival must cost at least this: max(c + 1, ceil(c (100 + percent) / 100)), at most kNoCost.
template <typename Sum>
constexpr Sum uniqueness_limit(Sum cost, int percent) noexcept {
  const std::uint64_t scaled =
      (std::uint64_t{cost} * (100U + static_cast<unsigned>(percent)) + 99U) / 100U;
  const std::uint64_t limit = scaled > cost ? scaled : std::uint64_t{cost} + 1U;
  return limit < kNoCost<Sum> ? static_cast<Sum>(limit) : kNoCost<Sum>;
}
static_assert(uniqueness_limit<std::uint16_t>(200, 15) == 230);
static_assert(uniqueness_limit<std::uint16_t>(0, 15) == 1);

}  // namespace stof::dsp
