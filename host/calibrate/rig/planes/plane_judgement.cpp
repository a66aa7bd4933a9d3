#include "host/calibrate/rig/planes/plane_judgement.h"

#include <algorithm>
#include <cmath>

#include <Eigen/Cholesky>

#include "dataset/files/file.h"

namespace stof::host {
namespace {

constexpr std::size_t kFewestDepths = 100;
constexpr double kDropSigmas = 5;
constexpr double kSigmaOfMad = 1.4826;
constexpr int kRounds = 5;
// A matcher's gross errors would move the first fit: it begins with depths near the wall.
constexpr double kNearWall = 0.1;
constexpr int kTable2Steps = 320;  // of the offset that is looked for, a pixel each, to both sides
constexpr std::size_t kFewestFitted = 3;

struct DepthPoint {
  double x;  // right of the perpendicular of the baseline, m
  double y;
  double z;
};

std::vector<DepthPoint> points_of(const Plane& plane, const PlaneSensor& sensor,
                                  const PlaneUnknowns& x) {
  std::vector<DepthPoint> points;
  for (int row = 0; row < plane.disparity.height; ++row) {
    for (int column = 0; column < plane.disparity.width; ++column) {
      const auto d = static_cast<double>(plane.disparity.view().at(column, row));
      if (!std::isfinite(d)) {
        continue;
      }
      const PlaneCell cell{.left = static_cast<double>(column),
                           .right = column - d,
                           .row = static_cast<double>(row)};
      const double z = depth_of(x.data(), sensor.left_m(cell), sensor.right_m(cell));
      if (std::isfinite(z) && z > 0) {
        const double tangent = tangent_of(std::tan(x[2]), -sensor.left_m(cell) / x[4]);
        points.push_back({-tangent * z, (row - sensor.cy) * sensor.pixel_m / x[4] * z, z});
      }
    }
  }
  return points;
}

// Z = a + b X + c Y by least squares.
Eigen::Vector3d plane_through(const std::vector<DepthPoint>& points) {
  Eigen::Matrix3d normal = Eigen::Matrix3d::Zero();
  Eigen::Vector3d right = Eigen::Vector3d::Zero();
  for (const DepthPoint& p : points) {
    const Eigen::Vector3d row(1, p.x, p.y);
    normal += row * row.transpose();
    right += row * p.z;
  }
  return normal.ldlt().solve(right);
}

double off(const DepthPoint& p, const Eigen::Vector3d& plane) {
  return p.z - plane.dot(Eigen::Vector3d(1, p.x, p.y));
}

double median(std::vector<double> values) {
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::ranges::nth_element(values, middle);
  return *middle;
}

PlaneCalibration::Chapter judge_chapter(const std::vector<Plane>& fitted,
                                        const PlaneCalibrationOptions& options,
                                        const PlaneUnknowns& refined) {
  const PlaneSensor& sensor = options.sensor;
  PlaneCalibration::Chapter chapter;
  chapter.genes = evolve_chapter(fitted, sensor, 0, options.genes);
  PlaneSensor table2 = sensor;
  table2.pixel_m = kTable2PixelM;
  chapter.table2_rms_m = chapter_rms_m(fitted, table2, kTable2, 0);
  chapter.table2_best_rms_m = chapter.table2_rms_m;
  for (int offset = -kTable2Steps; offset <= kTable2Steps; ++offset) {
    const double rms = chapter_rms_m(fitted, table2, kTable2, offset);
    if (rms < chapter.table2_best_rms_m) {
      chapter.table2_best_rms_m = rms;
      chapter.best_offset_px = offset;
    }
  }
  chapter.refined_rms_m = chapter_rms_m(fitted, sensor, refined, 0);
  chapter.elsewhere_rms_m = depth_rms_m(fitted, sensor, chapter.genes.x);
  return chapter;
}

}  // namespace

std::optional<WallJudgement> judge_wall(const Plane& plane, const PlaneSensor& sensor,
                                        const PlaneUnknowns& x) {
  const std::vector<DepthPoint> all = points_of(plane, sensor, x);
  std::vector<DepthPoint> kept;
  std::ranges::copy_if(all, std::back_inserter(kept), [&](const DepthPoint& p) {
    return std::abs(p.z - plane.z_m) < kNearWall * plane.z_m;
  });
  if (kept.size() < kFewestDepths) {
    return std::nullopt;
  }
  Eigen::Vector3d fit = plane_through(kept);
  for (int round = 0; round < kRounds; ++round) {
    std::vector<double> offs;
    offs.reserve(kept.size());
    for (const DepthPoint& p : kept) {
      offs.push_back(std::abs(off(p, fit)));
    }
    const double limit = kDropSigmas * std::max(kSigmaOfMad * median(std::move(offs)), 1e-6);
    kept.clear();
    std::ranges::copy_if(all, std::back_inserter(kept),
                         [&](const DepthPoint& p) { return std::abs(off(p, fit)) <= limit; });
    if (kept.size() < kFewestDepths) {
      return std::nullopt;
    }
    fit = plane_through(kept);
  }
  double squares = 0;
  for (const DepthPoint& p : kept) {
    squares += off(p, fit) * off(p, fit);
  }
  const auto count = static_cast<double>(kept.size());
  return WallJudgement{.name = plane.name,
                       .z_m = plane.z_m,
                       .pixels = static_cast<double>(all.size()),
                       .dropped = 1 - count / static_cast<double>(all.size()),
                       .spread_m = std::sqrt(squares / (count - 3)),
                       .bias_m = fit(0) - plane.z_m,
                       .fitted = false};
}

double pooled_spread_m(const std::vector<WallJudgement>& walls, bool fitted) {
  double squares = 0;
  double pixels = 0;
  for (const WallJudgement& wall : walls) {
    if (wall.fitted == fitted) {
      const double kept = wall.pixels * (1 - wall.dropped);
      squares += wall.spread_m * wall.spread_m * kept;
      pixels += kept;
    }
  }
  return std::sqrt(squares / pixels);
}

dataset::Loaded<PlaneCalibration> calibrate_planes(const std::vector<Plane>& planes,
                                                   const PlaneCalibrationOptions& options) {
  std::vector<Plane> fitted;
  std::vector<bool> is_fitted;
  const auto step = static_cast<std::size_t>(std::max(options.hold_out, 0));
  for (std::size_t n = 0; n < planes.size(); ++n) {
    // Neither the nearest nor the farthest: what judges lies between.
    const bool judges = step > 1 && n % step == step / 2 && n > 0 && n + 1 < planes.size() &&
                        planes.size() - planes.size() / step >= kFewestFitted + 1;
    is_fitted.push_back(!judges);
    if (!judges) {
      fitted.push_back(planes[n]);
    }
  }
  PlaneCalibration result;
  result.genes = evolve(fitted, options.sensor, options.priors, options.genes);
  const std::optional<PlaneFit> fit =
      refine(fitted, options.sensor, options.priors, result.genes.x);
  if (!fit) {
    return dataset::refuse(
        "no rig explains these walls: check their distances, --baseline and --focal");
  }
  result.fit = *fit;
  result.refined_rms_m = depth_rms_m(fitted, options.sensor, fit->x);
  for (std::size_t n = 0; n < planes.size(); ++n) {
    std::optional<WallJudgement> wall = judge_wall(planes[n], options.sensor, fit->x);
    if (!wall) {
      return dataset::refuse(planes[n].name +
                             ": hardly any depth lies near the wall: check its plane_z_m");
    }
    wall->fitted = is_fitted[n];
    result.walls.push_back(std::move(*wall));
  }
  if (options.chapter) {
    result.chapter = judge_chapter(fitted, options, fit->x);
  }
  return result;
}

dsp::StereoRig rig_of(const PlaneUnknowns& x, const PlaneSensor& sensor, int width, int height) {
  dsp::StereoRig rig;
  const double focal_px = (x[3] + x[4]) / 2 / sensor.pixel_m;
  rig.left = {.width = width,
              .height = height,
              .fx = focal_px,
              .fy = focal_px,
              .cx = sensor.cx_left,
              .cy = sensor.cy};
  rig.baseline_m = x[0];
  rig.converging = dsp::Converging{.alpha_rad = x[1],
                                   .beta_rad = x[2],
                                   .f1_m = x[3],
                                   .f2_m = x[4],
                                   .pixel_m = sensor.pixel_m,
                                   .cx_left = sensor.cx_left,
                                   .cx_right = sensor.cx_right};
  dsp::complete(rig);
  return rig;
}

}  // namespace stof::host
