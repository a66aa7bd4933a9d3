#pragma once

#include <optional>

#include "dsp/fusion/drift/drift_monitor.h"
#include "dsp/fusion/drift/plane_reader.h"

namespace stof::dsp {

// Measured less expected disparity over a plane.
struct DisparityShift {
  double px = 0;
  double variance = 0;
};

// The disparity map says roughly (the median over the plane's pixels), the grey values then in two
// steps by least squares, which knows neither the matcher's whole pixels nor the slant that blocks
// ignore:
//   left(x) = a_b + gain right(x - d - e),  linear in what is left of e
// after a 1 2 1 filter along the rows, with a constant a_b for each of 4x4 blocks: smooth shading
// and highlights say nothing. No block counts with more than the median block's texture, so the
// outline of something else does not decide. The variance is that of the blocks' disagreement.
// Nothing where stereo has no disparity for half of the pixels or they disagree, where texture is
// not well above noise, where blocks disagree by more than noise (not one plane), or where the fit
// leaves the disparity map.
std::optional<DisparityShift> disparity_shift(const ExpectedPlane& plane,
                                              const MatchedPair& pair) noexcept;

}  // namespace stof::dsp
