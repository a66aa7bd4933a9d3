#pragma once

#include <array>
#include <optional>
#include <span>

#include "dataset/dataset.h"
#include "dsp/calib/calibration.h"
#include "dsp/fusion/depth_map.h"

namespace stof::host {

inline constexpr double kFloorReachM = 4;   // floor farther away is not counted
inline constexpr double kObstacleM = 0.03;  // what stands higher is an obstacle to a robot

// A depth map on the pixels of one surface. Shares are in 0..1; what has no pixel to count is
// absent.
struct SurfaceScore {
  std::size_t pixels = 0;
  std::optional<double> off;      // share that is off by more than kLargestRelativeError
  std::optional<double> missing;  // share that has no depth
  // The errors of the others.
  std::optional<double> median_error_m;
  std::optional<double> p95_error_m;  // 95 percent of them err less
};

// A depth map of a scene above a floor. Counted is what both cameras see.
struct FloorScore {
  std::array<SurfaceScore, dataset::kSurfaces> surfaces;  // by dataset::Surface
  std::optional<double> missing_anywhere;  // as missing of the floor, also where one camera sees it
  std::optional<double> obstacle;          // share of the floor that seems higher than kObstacleM
  // Share of the lower floor that seems less than half as low as it is: nobody would stop there.
  std::optional<double> no_drop;
  std::optional<double> conflict;  // share of the glass on which the sensors contradict each other

  const SurfaceScore& of(dataset::Surface surface) const {
    return surfaces[static_cast<std::size_t>(surface)];
  }
};

// The truth of a scene above a floor; all pictures of one size.
struct FloorReference {
  const dataset::FloorTruth& floor;
  const dataset::Image<std::uint8_t>& visible;  // not 0: both cameras see it
  const dataset::Image<float>& depth;           // Z in metres, +inf = unknown
  const dsp::Pinhole& lens;                     // of the left camera
};

// How far above the floor, as the pose and the lens put it, the true floor lies: the median, in
// metres. None where no floor is near enough to count.
std::optional<double> floor_above_pose(const FloorReference& reference);

// Z in metres, +inf = none; source: of each pixel, or empty.
FloorScore score_floor(const dataset::Image<float>& depth, std::span<const dsp::Source> source,
                       const FloorReference& reference);

// The mean of each number over the scores that have it; pixels are the sum.
FloorScore mean_score(std::span<const FloorScore> scores);

}  // namespace stof::host
