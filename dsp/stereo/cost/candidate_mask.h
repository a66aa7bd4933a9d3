#pragma once

#include <cstdint>
#include <limits>
#include <span>

#include "dsp/base/image.h"
#include "dsp/base/kernel.h"
#include "dsp/stereo/cost/sad.h"

namespace stof::dsp {

// The candidates that may match a left pixel: first .. last, counted as in winner.h. last may lie
// beyond the last candidate; first > last: none may.
struct Candidates {
  std::uint8_t first = 0;
  std::uint8_t last = std::numeric_limits<std::uint8_t>::max();
  friend constexpr bool operator==(Candidates, Candidates) noexcept = default;
};
static_assert(sizeof(Candidates) == 2);

// The candidates that a guide leaves to the pixels of a left picture, one row or all of them;
// empty: there is no guide.
using GuideRow = std::span<const Candidates>;
using Guide = ImageView<const Candidates>;
inline GuideRow row_of(Guide guide, int y) noexcept {
  return guide.empty() ? GuideRow{} : GuideRow{guide.row(y)};
}

// out[x][i] = costs[x][i] for the candidates of guide[x] and one more to either side, kNoCost for
// all others. The one more is there to be compared with: a fit of costs needs both neighbours of
// its winner, and a cost that falls towards what may not match has no minimum in what may
// (keep_guided). costs, out: guide.size() * lanes sums laid out as in sad.h, lanes a multiple of
// 16, at most 256; the same memory, or no overlap. Sum is u8, u16 or u32.
template <typename Sum>
using MaskCandidates = void(std::span<const Sum> costs, GuideRow guide, int lanes,
                            std::span<Sum> out) noexcept;
STOF_KERNELS(MaskCandidates, mask_candidates, Neon<std::uint8_t>, Neon<std::uint16_t>,
             Neon<std::uint32_t>)

// Whether the guide leaves out any of so many candidates; an empty one does not.
bool narrows(GuideRow guide, int candidates) noexcept;

// Winners that may not match become kNoWinner. Equal lengths; an empty guide changes nothing.
void keep_guided(GuideRow guide, std::span<std::int16_t> winners) noexcept;

}  // namespace stof::dsp
