#pragma once

#include <array>
#include <optional>
#include <span>
#include <vector>

#include "dataset/dataset.h"
#include "dsp/base/fixed.h"
#include "dsp/base/image.h"
#include "dsp/calib/calibration.h"

namespace stof::host {

// E5 counts what is off by more than this share of the depth.
inline constexpr double kLargestRelativeError = 0.05;

// A thing that is nearer than told by more than this, metres: a robot drives into it.
inline constexpr double kCollisionM = 1;

// A depth map with its interval: Z in metres in the left view, +inf = none in all three.
struct DepthPlanes {
  dataset::Image<float> depth;
  dataset::Image<float> low;
  dataset::Image<float> high;
};

// Against truth. Shares are in 0..1; medians are over the pixels that have truth and a depth, the
// mean of the middle two where their number is even, and absent where there is none.
inline constexpr int kWidthParts = 4;
struct DepthScore {
  double e5 = 1;        // pixels with truth that are missing or off by more than 5 % of the truth
  double coverage = 0;  // pixels with truth that have a depth
  std::size_t truth_pixels = 0;
  std::optional<double> median_error_m;
  std::optional<double> median_relative;  // of |error| / truth
  std::optional<double> hit_rate;         // covered pixels whose truth lies in [low, high]
  std::optional<double> collisions;      // covered pixels told farther than they are by kCollisionM
  std::optional<double> median_width_m;  // of high - low
  std::optional<double> median_width_relative;  // of (high - low) / truth
  // hit_rate of each quarter of the intervals, narrowest quarter first.
  std::array<std::optional<double>, kWidthParts> hit_rate_by_width;
};

// All of one size; truth in metres, +inf = unknown.
DepthScore score_depth(const DepthPlanes& planes, const dataset::Image<float>& truth);

// The mean of each number over the scores that have it; truth_pixels is the sum. An empty span
// gives an empty score.
DepthScore mean_score(std::span<const DepthScore> scores);

// One published interval against the truth.
struct IntervalCheck {
  double width_m = 0;  // high - low
  bool hit = false;    // the truth lies in it
};
// The checks of all pixels that have truth and a depth, row by row.
std::vector<IntervalCheck> check_intervals(const DepthPlanes& planes,
                                           const dataset::Image<float>& truth);
// The share of hits in each of `parts` equal parts of the intervals ordered by width, narrowest
// first; equally wide ones stay in the order given. Absent where a part is empty.
std::vector<std::optional<double>> hit_rates_by_width(std::span<const IntervalCheck> checks,
                                                      int parts);

// Metres, interval [depth - width / 2, depth + width / 2]. Both of one size.
DepthPlanes to_metres(dsp::ImageView<const dsp::QuarterMm> depth,
                      dsp::ImageView<const dsp::QuarterMm> width);

// Z = f b / (d + doff); +inf where there is no disparity or it does not lie before the rig.
dataset::Image<float> depth_from_disparity(const dataset::Image<float>& disparity,
                                           const dsp::StereoRig& rig);

}  // namespace stof::host
