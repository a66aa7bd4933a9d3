#include "dsp/fusion/drift/plane_reader.h"

#include <algorithm>
#include <cmath>

#include "dsp/base/fixed.h"
#include "dsp/base/index.h"

namespace stof::dsp {
namespace {

// Where a number was chosen, the range over which it was varied stands beside it: see
// disparity_shift.cpp.

// Side of a patch in the left picture, px: wide enough for 4x4 blocks of texture, small enough for
// one plane (chosen: 16 to 36). In PMD pixels it lies within these sides: a plane needs a few
// readings, and Readings holds no more.
constexpr double kPatchPx = 24;
constexpr int kSmallestSide = 4;
constexpr int kLargestSide = 16;
constexpr double kNearestM = 0.01;  // before the camera; what is nearer has no place
// Steps of the numeric derivatives: large against the rounding of a place (1e-13 px), small against
// the distances of things.
constexpr double kTurnStep = 1e-4;   // rad
constexpr double kRangeStep = 1e-3;  // m
// Readings may lie so far about their plane, rms: times their noise (the rms of 16 readings
// scatters by a fifth), and pixels of disparity (chosen: 1 to 2; 0.02 to 0.2).
constexpr double kMisfitNoise = 1.3;
constexpr double kMisfitPx = 0.06;
// Of the determinant of places over what they would have without correlation: below it they lie on
// one line.
constexpr double kLeastSpread = 1e-6;
// Of a patch's readings, those that may be missing where something moved: few walls are bright
// enough everywhere, and with none a rig that drives has no estimate at 320x240.
// None where all stands still: there what is left of a patch at the limit is wrong in every frame
// alike (a range of 15 mm in one room of ten, 88x72).
constexpr double kMostMissing = 0.25;

}  // namespace

struct PlaneReader::Readings {
  std::array<Place, pixel_count(kLargestSide, kLargestSide)> places{};
  // Where something moved each reading has another noise: (relative_noise distance / sigma)^2;
  // elsewhere 1.
  std::array<double, pixel_count(kLargestSide, kLargestSide)> weights{};
  std::size_t count = 0;
  Point middle{};
  double relative_noise = 0;  // mean of sigma / distance
};

PlaneReader::PlaneReader(const Calibration& calibration, Arena& arena) noexcept
    : rig_(calibration.stereo),
      origin_(calibration.pmd_to_stereo.translation_m),
      width_(calibration.pmd.lens.width) {
  const Pinhole& lens = calibration.pmd.lens;
  if (lens.width == 0 || lens.height == 0) {
    return;
  }
  if (const auto& axes = rig_.converging) {
    tan_left_ = std::tan(axes->beta_rad);
    tan_right_ = std::tan(axes->alpha_rad);
  }
  side_ = static_cast<int>(std::clamp(std::round(kPatchPx * lens.fx / rig_.left.fx),
                                      double{kSmallestSide}, double{kLargestSide}));
  rays_ = make_ray_table(calibration, arena);
}

std::optional<PlaneReader::Place> PlaneReader::place(const Point& point) const noexcept {
  const auto& [x, y, z] = point;
  if (!(z >= kNearestM)) {
    return std::nullopt;
  }
  const Pinhole& left = rig_.left;
  const auto& axes = rig_.converging;
  if (!axes) {
    return Place{.u = left.fx * x / z + left.cx,
                 .v = left.fy * y / z + left.cy,
                 .d = left.fx * rig_.baseline_m / z - rig_.doff_px};
  }
  // Tangents to the left of the perpendicular, seen from both cameras, each turned by its yaw.
  const double from_left = -x / z;
  const double from_right = from_left + rig_.baseline_m / z;
  const double ahead = 1 + from_left * tan_left_;
  const double ahead_right = 1 + from_right * tan_right_;
  if (!(ahead > 0) || !(ahead_right > 0)) {
    return std::nullopt;
  }
  const double focal = axes->f2_m / axes->pixel_m;
  const double u = axes->cx_left - focal * (from_left - tan_left_) / ahead;
  const double right =
      axes->cx_right - axes->f1_m / axes->pixel_m * (from_right - tan_right_) / ahead_right;
  const double stretch = std::sqrt(1 + tan_left_ * tan_left_) / ahead;
  return Place{.u = u, .v = focal * y / z * stretch + left.cy, .d = u - right};
}

std::optional<PlaneReader::Readings> PlaneReader::collect(int x, int y,
                                                          const PmdMaps& maps) const noexcept {
  Readings out;
  for (int row = y; row < y + side_; ++row) {
    const std::span<const QuarterMm> distances = maps.distance.row(row);
    const std::span<const QuarterMm> sigmas = maps.sigma.row(row);
    const std::span<const std::uint8_t> flags = maps.flags.row(row);
    for (int column = x; column < x + side_; ++column) {
      const std::size_t i = index(column);
      const std::size_t at = pixel_count(width_, row) + i;
      if (distances[i] == kNoDepth || (flags[i] & kPmdMissing) != 0) {
        continue;
      }
      const double scale = double{1} * distances[i] / kQuarterMmPerMetre / kQ15One;
      const Point point{origin_[0] + scale * rays_.turned_x[at],
                        origin_[1] + scale * rays_.turned_y[at],
                        origin_[2] + scale * rays_.turned_z[at]};
      const std::optional<Place> there = place(point);
      if (!there) {
        return std::nullopt;
      }
      out.places[out.count] = *there;
      out.weights[out.count] = double{1} * sigmas[i] / distances[i];
      out.relative_noise += out.weights[out.count];
      ++out.count;
      for (std::size_t k = 0; k < 3; ++k) {
        out.middle[k] += point[k];
      }
    }
  }
  const double n = static_cast<double>(out.count);
  if (n < (maps.moved ? 1 - kMostMissing : 1) * side_ * side_) {
    return std::nullopt;
  }
  for (double& m : out.middle) {
    m /= n;
  }
  out.relative_noise /= n;
  for (double& weight : std::span(out.weights).first(out.count)) {
    const double share = maps.moved && weight > 0 ? out.relative_noise / weight : 1;
    weight = share * share;
  }
  return out;
}

bool PlaneReader::fit(const Readings& readings, ExpectedPlane& plane) const noexcept {
  const std::span<const Place> places = std::span(readings.places).first(readings.count);
  const double n = static_cast<double>(readings.count);
  double all = 0;
  for (std::size_t i = 0; i < places.size(); ++i) {
    all += readings.weights[i];
  }
  plane.u_low = plane.u_high = places[0].u;
  plane.v_low = plane.v_high = places[0].v;
  for (std::size_t i = 0; i < places.size(); ++i) {
    const Place& p = places[i];
    const double w = readings.weights[i];
    plane.u += w * p.u / all;
    plane.v += w * p.v / all;
    plane.d += w * p.d / all;
    plane.u_low = std::min(plane.u_low, p.u);
    plane.u_high = std::max(plane.u_high, p.u);
    plane.v_low = std::min(plane.v_low, p.v);
    plane.v_high = std::max(plane.v_high, p.v);
  }
  double uu = 0;
  double uv = 0;
  double vv = 0;
  double ud = 0;
  double vd = 0;
  double dd = 0;
  for (std::size_t i = 0; i < places.size(); ++i) {
    const double w = readings.weights[i];
    const double u = places[i].u - plane.u;
    const double v = places[i].v - plane.v;
    const double d = places[i].d - plane.d;
    uu += w * u * u;
    uv += w * u * v;
    vv += w * v * v;
    ud += w * u * d;
    vd += w * v * d;
    dd += w * d * d;
  }
  const double determinant = uu * vv - uv * uv;
  if (!(determinant > kLeastSpread * uu * vv) || !(uu > 0) || !(vv > 0)) {
    return false;
  }
  plane.gx = (vv * ud - uv * vd) / determinant;
  plane.gy = (uu * vd - uv * ud) / determinant;
  const double parallax = plane.d + rig_.doff_px;  // proportional to 1 / Z
  const double noise = readings.relative_noise * parallax;
  plane.variance = noise * noise / all;
  // The mean of 1 / (Z + noise) is more than 1 / Z.
  plane.d -= readings.relative_noise * readings.relative_noise * parallax * (n / all);
  const double misfit = (dd - plane.gx * ud - plane.gy * vd) / (n - 3);
  return misfit <= kMisfitNoise * kMisfitNoise * noise * noise + kMisfitPx * kMisfitPx;
}

bool PlaneReader::add_slope(const Point& middle, ExpectedPlane& plane) const noexcept {
  const Point q{middle[0] - origin_[0], middle[1] - origin_[1], middle[2] - origin_[2]};
  const double length = std::sqrt(q[0] * q[0] + q[1] * q[1] + q[2] * q[2]);
  const std::optional<Place> here = place(middle);
  if (!here || !(length > 0)) {
    return false;
  }
  // The truth less the reading's point: axis x q; towards the camera.
  const std::array<Point, 4> moves{Point{0, -q[2], q[1]}, Point{q[2], 0, -q[0]},
                                   Point{-q[1], q[0], 0},
                                   Point{-q[0] / length, -q[1] / length, -q[2] / length}};
  for (std::size_t k = 0; k < moves.size(); ++k) {
    const double step = k < 3 ? kTurnStep : kRangeStep;
    const std::optional<Place> there =
        place({middle[0] + step * moves[k][0], middle[1] + step * moves[k][1],
               middle[2] + step * moves[k][2]});
    if (!there) {
      return false;
    }
    plane.slope[k] =
        (there->d - here->d - plane.gx * (there->u - here->u) - plane.gy * (there->v - here->v)) /
        step;
  }
  plane.slope[4] = 1;
  return true;
}

std::optional<ExpectedPlane> PlaneReader::read(int x, int y, const PmdMaps& maps) const noexcept {
  const std::optional<Readings> readings = collect(x, y, maps);
  ExpectedPlane plane;
  if (!readings || !fit(*readings, plane) || !add_slope(readings->middle, plane)) {
    return std::nullopt;
  }
  return plane;
}

}  // namespace stof::dsp
