#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <limits>

#include "dsp/base/arena.h"
#include "dsp/base/fixed.h"
#include "dsp/base/image.h"
#include "dsp/calib/calibration.h"
#include "dsp/pmd/converter.h"

namespace stof::dsp {

// How far a rig has drifted from its calibration, as far as the disagreement between stereo and PMD
// tells. Published as health, applied to nothing. It is neither image data nor on the way of a
// result, so it computes in double precision: +, -, *, / and sqrt in a fixed order, the same bits
// everywhere.
//
// A patch of the PMD picture that shows one plane is carried into the left view; there the pictures
// of the pair say, by a least-squares fit of grey values along the rows (disparity_shift.h), how
// far the true disparity is from the expected one. A turn of the PMD camera moves the plane across
// its own slope g, a range offset moves it along the ray; to first order
//   e = sum over k of drift_k J_k,  J_k = dd_k - g_x du_k - g_y dv_k
// where (du, dv, dd) is how the patch's true place and disparity differ from the expected ones for
// drift_k = 1. Each patch keeps the mean of e and J over time, older frames fading; the solution is
// weighted least squares over patches, in which those that contradict (a reflection, a corner taken
// for a plane, somebody who walks by) lose their weight.
//
// Where the rig moves, the PMD camera sees it elsewhere than the pair did: its exposure is longer,
// so its middle is later by a lag. What the rig turned by in that time is a drift of its own. It is
// known from what the left picture's content moved by since the frame before (picture_shift.h), and
// taken away as
//   e - turn_pitch J_pitch - turn_yaw J_yaw,  turn = lag / time between both pictures * shift / f
// It is uncertain by a share of itself. What the rig drives in that time is not known: of a frame
// that moved, the range is uncertain by what it may be.
//
// A scene that stands still repeats its errors in every frame: the number of frames says nothing
// about them. Standard deviations come from leaving out one region of the picture after the other
// or one column or row (jackknife), so a parameter that a single thing decides about is as
// uncertain as that thing. A parameter that a scene does not show (yaw before a floor alone) stays
// unknown.

enum class DriftParameter : std::uint8_t {
  kPitch,      // turn of the PMD camera at its own origin about the x axis of the left camera,
               // upwards: the truth is X_stereo = (1 + [turn]x) R X_pmd + T
  kYaw,        // about y, to the right
  kRoll,       // about z, clockwise
  kRange,      // what the PMD measures too much, along the ray
  kDisparity,  // what stereo measures too much: of the pair itself, and hard to tell from a turn;
               // solved for so that a little of it does not count as one
};
inline constexpr std::size_t kDriftParameters = 5;
using DriftVector = std::array<double, kDriftParameters>;  // radians, metres, pixels

inline constexpr std::int32_t kDriftUnknown = std::numeric_limits<std::int32_t>::max();

// Turns in micro-radians, the range offset in 1/16 mm, the disparity offset in 1/1000 px.
struct Drift {
  std::int32_t value = 0;
  std::int32_t sigma = kDriftUnknown;  // standard deviation of value
  bool significant = false;            // as DriftParams say
};

struct DriftEstimate {
  std::array<Drift, kDriftParameters> drifts{};  // in the order of DriftParameter
  std::uint32_t patches = 0;                     // that say something at present
  bool significant = false;                      // one of the drifts is

  const Drift& operator[](DriftParameter parameter) const noexcept {
    return drifts[static_cast<std::size_t>(parameter)];
  }
};

struct DriftParams {
  double fade_frames = 450;  // observe() calls until one counts 1 / e: 15 s at 30 a second
  // Reported is what exceeds so many standard deviations and its floor.
  double sigmas = 3;
  // The drift that a good calibration leaves: 0.03 degrees (roll 0.04), 15 mm, 0.08 px. A parameter
  // known less well than that is reported where it exceeds the root of the sum of both squares.
  DriftVector floor{5.24e-4, 5.24e-4, 6.98e-4, 0.015, 0.08};
};

// The pair as it was matched (rectified where the rig asks for it) and what came of it.
struct MatchedPair {
  ImageView<const std::uint8_t> left;
  ImageView<const std::uint8_t> right;
  ImageView<const Disparity> disparity;
};

class DriftMonitor {
 public:
  // The calibration is complete(); with a PMD size of 0x0 nothing is ever observed.
  DriftMonitor(const Calibration& calibration, const DriftParams& params, Arena& arena) noexcept;

  // The left picture of a pair, before observe() of it; also where there are no new samples.
  // since_us: from the middle of the exposure of the pair before it, microseconds; 0: a gap.
  void follow(ImageView<const std::uint8_t> left, std::int32_t since_us) noexcept;
  // One frame, of which every eighth patch in turn is looked at: half a millisecond for
  // 176x144 pixels in a corridor, one where all of them show textured planes. Pictures of any size
  // (equal ones); maps that are not of the calibration's size say nothing, nor does a frame where
  // nobody knows how far the rig turned. pmd_lag_us: from the middle of the pair's exposure to that
  // of the samples, microseconds.
  void observe(const MatchedPair& pair, const PmdMaps& maps, std::int32_t pmd_lag_us = 0) noexcept;
  // Below 0.3 ms; once a second is plenty.
  DriftEstimate estimate() const noexcept;
  void forget() noexcept;

 private:
  struct State;
  State* state_;
};

}  // namespace stof::dsp
