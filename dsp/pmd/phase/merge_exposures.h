#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

#include "dsp/base/fixed.h"
#include "dsp/base/kernel.h"

namespace stof::dsp {

// One row of the results of phase and sigma_and_ratio for one exposure. ratio and sigma may be
// empty (in all rows that are merged).
struct ExposureRow {
  std::span<Phase> phase;
  std::span<std::uint16_t> amp2;
  std::span<std::uint16_t> offset;
  std::span<std::uint8_t> ratio;
  std::span<QuarterMm> sigma;
  std::span<std::uint8_t> flags;
};

inline constexpr std::uint16_t kUnchangedQ8 = 256;

// One more exposure of a scene that was taken several times: from every pixel the longest exposure
// none of whose samples is saturated, or, where all are, the shortest one with its flags.
// Where `merged` has kPmdSaturated it becomes what `shorter` is there, and taken becomes `index`:
//   phase, ratio, sigma, flags  as they are
//   amp2, offset                min((value * gain_q8 + 128) >> 8, 65535); with gain_q8 = 256 they
//                               stay in LSB of the exposure taken
// `merged` begins as the longest exposure and `taken` as its index; then called for each shorter
// one, the longest of them first. Equal lengths, any length, any alignment; no overlap.
using MergeExposuresKernel = void(const ExposureRow& shorter, std::uint8_t index,
                                  std::uint16_t gain_q8, const ExposureRow& merged,
                                  std::span<std::uint8_t> taken) noexcept;
STOF_KERNEL(MergeExposuresKernel, merge_exposures, kNeon)

// Lengths as above, n of taken.
void check_merge_exposures(const ExposureRow& shorter, const ExposureRow& merged,
                           std::size_t n) noexcept;

}  // namespace stof::dsp
