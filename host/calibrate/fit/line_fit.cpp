#include "host/calibrate/fit/line_fit.h"

#include <algorithm>
#include <cmath>
#include <complex>
#include <limits>
#include <numbers>

namespace stof::host {
namespace {

constexpr double kCountsPerTurn = 138.7;
constexpr double kCentimetres = 100;

// Sums over the usable pixels in the middle of one wall.
struct MiddleSums {
  double count = 0;
  double forward = 0;  // r_z
  double along = 0;    // r_z d
};

MiddleSums sums_of(const WallData& data, const PmdModel& model, const Wall& wall) {
  const Middle middle = middle_of(data.lens);
  MiddleSums sums;
  for (int y = middle.top; y < middle.bottom; ++y) {
    for (int x = middle.left; x < middle.right; ++x) {
      const std::size_t p = static_cast<std::size_t>(y * data.lens.width + x);
      const Reading& reading = wall.readings[p];
      const std::complex<double> iq(reading.i, model.phase_falls ? -reading.q : reading.q);
      const double forward = data.rays[p][2];
      if (reading.saturated || !(forward > 0) || std::abs(iq) < 2 * data.min_amplitude_lsb) {
        continue;
      }
      // The phase itself, in whole turns nearest to where the wall is.
      const double turns = std::arg(iq) / (2 * std::numbers::pi);
      const double expected = wall.z_m / forward / model.turn_m + model.offset;
      const double d = (expected + wrapped(turns - expected)) * model.turn_m;
      sums.count += 1;
      sums.forward += forward;
      sums.along += forward * d;
    }
  }
  return sums;
}

double z_of(const LineFit& line, const MiddleSums& sums) {
  return (line.a * sums.along + line.b_m * sums.forward) / sums.count;
}

struct Points {
  std::vector<MiddleSums> sums;
  std::vector<double> z_m;
};

Points points_from(const WallData& data, const PmdModel& model, double from_m) {
  Points points;
  for (const Wall& wall : data.walls) {
    const MiddleSums sums = sums_of(data, model, wall);
    if (sums.count > 0 && wall.z_m >= from_m) {
      points.sums.push_back(sums);
      points.z_m.push_back(wall.z_m);
    }
  }
  return points;
}

}  // namespace

double line_error(const LineFit& line, const WallData& data, const PmdModel& model,
                  const Wall& wall) {
  const MiddleSums sums = sums_of(data, model, wall);
  return sums.count > 0 ? z_of(line, sums) - wall.z_m : std::numeric_limits<double>::quiet_NaN();
}

std::optional<LineFit> fit_line(const WallData& data, const PmdModel& model) {
  Points points = points_from(data, model, kLineFromM);
  if (points.z_m.size() < 3) {
    points = points_from(data, model, 0);
  }
  // z = a u + b v with u = mean of r_z d, v = mean of r_z.
  double uu = 0, uv = 0, vv = 0, uz = 0, vz = 0;
  for (std::size_t i = 0; i < points.z_m.size(); ++i) {
    const double u = points.sums[i].along / points.sums[i].count;
    const double v = points.sums[i].forward / points.sums[i].count;
    uu += u * u;
    uv += u * v;
    vv += v * v;
    uz += u * points.z_m[i];
    vz += v * points.z_m[i];
  }
  const double determinant = uu * vv - uv * uv;
  if (points.z_m.size() < 2 || !(determinant > 1e-12 * uu * vv)) {
    return std::nullopt;
  }
  LineFit line{.a = (uz * vv - vz * uv) / determinant, .b_m = (vz * uu - uz * uv) / determinant};
  line.slope_cm = -line.a * model.turn_m / kCountsPerTurn * kCentimetres;
  line.intercept_cm = (line.a * model.turn_m + line.b_m) * kCentimetres;
  line.from_m = *std::ranges::min_element(points.z_m);
  for (std::size_t i = 0; i < points.z_m.size(); ++i) {
    const double error = z_of(line, points.sums[i]) - points.z_m[i];
    line.worst_relative = std::max(line.worst_relative, std::abs(error) / points.z_m[i]);
  }
  return line;
}

}  // namespace stof::host
