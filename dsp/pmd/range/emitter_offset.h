#pragma once

#include <cstdint>
#include <span>

#include "dsp/base/kernel.h"

namespace stof::dsp {

// Emitters beside the lens: the way out is not the way back. The measured distance is half of
// the way of the light; the result is the distance d of the surface along the pixel's ray r (a
// unit vector).
//
// One light at e: |d r - e| + d = L, L = 2 measured, so with c = e . r
//   d = (L^2 - |e|^2) / (2 (L - c)) = L / 2 + c / 2 - (|e|^2 - c^2) / (2 (L - c))  exactly.
// Several lights: the measured way is the mean of theirs, weighted by the light that comes back
// from each. The form stays the same,
//   d = L / 2 + mean c / 2 - V / (2 (L - c')),
// with V and c' of each pixel such that it is exact at two distances
// (dsp/calib/pmd/emitter_offset_table.h says which, and how good it is between and outside).
//
// Per pixel, in the units of distances (quarter mm or 0.1 mm):
struct EmitterOffsetRow {
  std::span<const std::int16_t> half_q2;     // mean c / 2, with 2 fraction bits
  std::span<const std::int32_t> twice_area;  // 2 V
  std::span<const std::int32_t> pole;        // c', magnitude below 2^20
};

// In place, for one row:
//   L = 2 min(d, kMostUnits); bend = twice_area / max(max(L, shortest) - pole, 1): one IEEE single
//   division of both rounded to single, limited to +-2^20 and rounded to nearest, ties to even
//   d = (4 min(d, kMostUnits) + half_q2 - bend + 2) >> 2, at least 1
// Below `shortest` (a way, so twice the distance) the correction stays as it is there: fits are
// worth nothing far below what they were made for. Equal lengths, any length, any alignment.
using EmitterOffsetKernel = void(const EmitterOffsetRow& table, std::uint32_t shortest,
                                 std::span<std::uint32_t> distance) noexcept;
STOF_KERNEL(EmitterOffsetKernel, emitter_offset, kNeon)

}  // namespace stof::dsp
