#pragma once

#include <cstdint>
#include <span>

#include "dsp/base/kernel.h"
#include "dsp/stereo/cost/sad.h"

// Winner takes all on one row of costs, laid out [column][candidate] as in sad.h.
namespace stof::dsp {

// No candidate won.
inline constexpr std::int16_t kNoWinner = -1;

// winners[x] = the candidate of lowest cost, the smallest one of a tie; kNoWinner where no
// candidate costs more than another: none was offered, only one, or all tie (a flat, black or
// saturated picture matches everywhere, which is no match). lanes a multiple of 16, at most 256;
// costs hold winners.size() * lanes sums.
template <typename Sum>
using Winners = void(std::span<const Sum> costs, int lanes,
                     std::span<std::int16_t> winners) noexcept;

// The same for the right image, from the same costs: right pixel j (counted from the right end of
// the row, see below) meets left pixel x as its candidate i when j = n - 1 - x + i. For each j the
// lowest cost and its smallest i; kNoWinner where no pixel offers a cost. Both outputs have
// n + lanes - 1 elements, n the number of columns; lowest is scratch and result.
// The right column of j is n - 1 - min_disparity - j.
template <typename Sum>
using RightWinners = void(std::span<const Sum> costs, int lanes, std::span<Sum> lowest,
                          std::span<std::int16_t> winners) noexcept;

STOF_KERNELS(Winners, winners, Avx2<std::uint8_t>, Avx2<std::uint16_t>, Neon<std::uint32_t>)
STOF_KERNELS(RightWinners, right_winners, Avx512<std::uint8_t>, Avx512<std::uint16_t>,
             Neon<std::uint32_t>)

}  // namespace stof::dsp
