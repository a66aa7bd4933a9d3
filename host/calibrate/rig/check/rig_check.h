#pragma once

#include <array>
#include <limits>
#include <optional>
#include <string>
#include <vector>

#include "dataset/dataset.h"
#include "host/calibrate/rig/extrinsics/wall_pairs.h"

// Whether a calibration still fits its rig, judged by pictures of anything.
namespace stof::host {

// How far rows of rectified pictures are apart, from corners that both eyes see.
struct RowCheck {
  std::size_t points = 0;
  double median_px = 0;  // right row less left row
  double rms_px = 0;
  double slope_px = 0;  // from the left border of the picture to the right one
};

// One feature that both rectified pictures show.
struct RowPoint {
  double u = 0;   // column in the left picture
  double dv = 0;  // right row less left row, px
};

// Features of the left picture, found again in the right one up to 12 rows off and
// min_disparity .. min_disparity + disparities columns.
std::vector<RowPoint> row_points(const dataset::Image<std::uint8_t>& left,
                                 const dataset::Image<std::uint8_t>& right,
                                 const WallPairOptions& options);
// None of fewer than 20 points. Wrong matches are left out.
std::optional<RowCheck> check_rows(const std::vector<RowPoint>& points, int width);

// How far the two sensors disagree: of 1 / Z, told as millimetres at 2 m; positive where the PMD
// camera reads farther.
struct DepthCheck {
  std::size_t points = 0;
  double median_mm = 0;
  double spread_mm = 0;  // robust standard deviation
  // From which turn of the PMD camera on, either way about x, y, z of the left camera, the median
  // would be more than is allowed, degrees; infinite: not up to kLargestTurnDeg.
  std::array<double, 3> turn_shows_deg{kNever, kNever, kNever};

  static constexpr double kNever = std::numeric_limits<double>::infinity();
};
inline constexpr double kLargestTurnDeg = 10;
std::optional<DepthCheck> check_depths(const std::vector<BothLooks>& looks,
                                       const dsp::Calibration& calibration);

struct RigCheck {
  std::optional<RowCheck> rows;
  std::optional<DepthCheck> depths;
};

inline constexpr double kLargestRowPx = 0.5;   // of median, rms or slope
inline constexpr double kLargestDepthMm = 20;  // of the median
// What to do, a line each; empty: nothing.
std::vector<std::string> advice(const RigCheck& check);
// What these pictures cannot tell, a line each.
std::vector<std::string> doubts(const RigCheck& check);

// The pairs of a folder; PMD recordings beside them count where the calibration has such a camera.
dataset::Loaded<RigCheck> check_rig(const std::filesystem::path& dir,
                                    const dsp::Calibration& calibration,
                                    const WallPairOptions& options);

}  // namespace stof::host
