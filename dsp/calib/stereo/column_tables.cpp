#include "dsp/calib/stereo/column_tables.h"

#include <cmath>
#include <cstddef>
#include <limits>

#include "dsp/base/check.h"

namespace stof::dsp {
namespace {

double tangent(double angle) noexcept {
  return std::abs(angle) <= kSteepestRad ? std::tan(angle)
                                         : std::numeric_limits<double>::quiet_NaN();
}

std::int32_t to_fixed(double tangent, std::int32_t none) noexcept {
  return std::isnan(tangent)
             ? none
             : static_cast<std::int32_t>(std::lround(std::ldexp(tangent, kTangentBits)));
}

}  // namespace

double left_tangent(const StereoRig& rig, double x) noexcept {
  if (const auto& c = rig.converging) {
    return tangent(c->beta_rad + std::atan(-(x - c->cx_left) * c->pixel_m / c->f2_m));
  }
  return tangent(std::atan(-(x - rig.left.cx) / rig.left.fx));
}

double right_tangent(const StereoRig& rig, double x) noexcept {
  if (const auto& c = rig.converging) {
    return tangent(c->alpha_rad + std::atan(-(x - c->cx_right) * c->pixel_m / c->f1_m));
  }
  return tangent(std::atan(-(x - rig.left.cx - rig.doff_px) / rig.left.fx));
}

double depth_of(const StereoRig& rig, double x, double d) noexcept {
  const double parallax = right_tangent(rig, x - d) - left_tangent(rig, x);
  return parallax <= 0 ? std::numeric_limits<double>::infinity() : rig.baseline_m / parallax;
}

ColumnTables make_column_tables(const StereoRig& rig, std::int16_t first_raw, std::int16_t last_raw,
                                QuarterMm max_range, std::span<std::int32_t> left,
                                std::span<std::int32_t> right) noexcept {
  STOF_CHECK(first_raw <= last_raw);
  STOF_CHECK(rig.baseline_m >= 1e-3 && rig.baseline_m <= 1e3);
  STOF_CHECK(right.size() == right_tangents(left.size(), first_raw, last_raw));
  for (std::size_t x = 0; x < left.size(); ++x) {
    left[x] = to_fixed(left_tangent(rig, static_cast<double>(x)), kNoLeftRay);
  }
  const double first_column = -(last_raw + double{kMostHalfWidth});
  for (std::size_t k = 0; k < right.size(); ++k) {
    const double column = (first_column + static_cast<double>(k)) / Disparity::kOne;
    right[k] = to_fixed(right_tangent(rig, column), kNoRightRay);
  }
  const double baseline = std::ldexp(rig.baseline_m * kQuarterMmPerMetre, kTangentBits);
  return {.first_raw = first_raw,
          .last_raw = last_raw,
          .max_range = max_range,
          .near_numerator = static_cast<std::int64_t>(std::floor(baseline)),
          .far_numerator = static_cast<std::int64_t>(std::ceil(baseline)),
          .left = left,
          .right = right};
}

}  // namespace stof::dsp
