#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

#include "dsp/base/fixed.h"
#include "dsp/calib/calibration.h"

// The tables of a GuideMaker (guide_maker.h), computed once at start, for rigs that it serves.
namespace stof::dsp {

// Depths are looked up in steps of 4 mm: element k stands for k .. k + 1 steps.
inline constexpr int kGuideDepthStep = 16;  // quarter mm
inline constexpr std::size_t kGuideDepths = (kMaxQuarterMm + 1) / kGuideDepthStep;
// Candidates, clamped: none of them is as small, or as large.
inline constexpr std::int16_t kBeforeCandidates = -1;
inline constexpr std::int16_t kBeyondCandidates = 256;

// first[k]: the candidate of the farthest depth of element k, and of `margin` of it (a share)
// beyond; last[k]: of the nearest, less the margin. Rounded outwards. kGuideDepths elements each.
void fill_guide_candidates(const StereoRig& rig, int min_disparity, double margin,
                           std::span<std::int16_t> first, std::span<std::int16_t> last) noexcept;

// Distances from the PMD, quarter mm, that stand for all at which stereo could match something: a
// thing that moves along any ray of the PMD moves by no more than two PMD pixels in the left view
// from one to the next. Returns how many it wrote, 1 to out.size().
std::size_t fill_guide_distances(const Calibration& calibration, int min_disparity, int disparities,
                                 std::span<QuarterMm> out) noexcept;

}  // namespace stof::dsp
