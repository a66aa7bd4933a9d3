#include "host/picture/height_field.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>

#include "host/picture/rasteriser.h"

namespace stof::host {
namespace {

constexpr float kSmoothStepPx = 1.25F;
constexpr float kCutPx = 2;
constexpr double kPlateBehind = 0.02;  // in picture widths
constexpr double kPlateMargin = 0.03;  // in picture widths

struct Vector {
  double x = 0;
  double y = 0;
  double z = 0;
  Vector operator-(const Vector& o) const { return {x - o.x, y - o.y, z - o.z}; }
};

double dot(const Vector& a, const Vector& b) { return a.x * b.x + a.y * b.y + a.z * b.z; }

Vector cross(const Vector& a, const Vector& b) {
  return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}

Vector unit(const Vector& v) {
  const double length = std::sqrt(dot(v, v));
  return length > 0 ? Vector{v.x / length, v.y / length, v.z / length} : Vector{0, 0, -1};
}

// The rotation and the perspective; picture widths, the middle of the plate is the origin, z away
// from the viewer.
class Viewpoint {
 public:
  explicit Viewpoint(const HeightFieldView& view)
      : yaw_(view.yaw_deg * std::numbers::pi / 180),
        pitch_(view.pitch_deg * std::numbers::pi / 180) {}

  // u right, v down, closeness.
  Corner project(const Vector& p) const {
    constexpr double kDistance = 2.6;
    const double x = p.x * std::cos(yaw_) - p.z * std::sin(yaw_);
    const double turned = p.x * std::sin(yaw_) + p.z * std::cos(yaw_);
    const double y = p.y * std::cos(pitch_) - turned * std::sin(pitch_);
    const double z = p.y * std::sin(pitch_) + turned * std::cos(pitch_) + kDistance;
    return {.u = x / z, .v = y / z, .closeness = 1 / z};
  }

 private:
  double yaw_;
  double pitch_;
};

// The height field in picture widths.
class Field {
 public:
  Field(const dataset::Image<float>& disparity, double far_px, double near_px, double height)
      : disparity_(smoothed_within(smoothed_within(disparity, 2, kSmoothStepPx), 2, kSmoothStepPx)),
        far_px_(far_px),
        near_px_(near_px),
        per_px_(height / (near_px - far_px)) {}

  int width() const { return disparity_.width; }
  int height() const { return disparity_.height; }
  bool there(int x, int y) const { return std::isfinite(disparity_.view().at(x, y)); }
  // Cut where the surface is not one.
  bool joined(std::array<std::pair<int, int>, 3> corners) const {
    float low = std::numeric_limits<float>::infinity();
    float high = -low;
    for (const auto& [x, y] : corners) {
      low = std::min(low, disparity_.view().at(x, y));
      high = std::max(high, disparity_.view().at(x, y));
    }
    return std::isfinite(high) && high - low <= kCutPx;
  }
  Vector on_plate(double x, double y, double z) const {
    const double width = disparity_.width;
    return {(x - (width - 1) / 2) / width, (y - (disparity_.height - 1) / 2.0) / width, z};
  }
  Vector point(int x, int y) const {
    const double d = std::clamp(static_cast<double>(disparity_.view().at(x, y)), far_px_, near_px_);
    return on_plate(x, y, -per_px_ * (d - far_px_));
  }
  Vector normal(int x, int y) const {
    // The farthest neighbour of two that still belongs to the surface.
    const auto reach = [&](int dx, int dy) {
      Vector found = point(x, y);
      for (int step = 1; step <= 2; ++step) {
        const int nx = x + step * dx;
        const int ny = y + step * dy;
        if (nx < 0 || nx >= width() || ny < 0 || ny >= height() ||
            !joined({{{x, y}, {nx, ny}, {nx, ny}}})) {
          break;
        }
        found = point(nx, ny);
      }
      return found;
    };
    const Vector normal = unit(cross(reach(1, 0) - reach(-1, 0), reach(0, 1) - reach(0, -1)));
    return normal.z > 0 ? Vector{-normal.x, -normal.y, -normal.z} : normal;
  }

 private:
  dataset::Image<float> disparity_;
  double far_px_;
  double near_px_;
  double per_px_;
};

Light lit(const Vector& normal, double grey) {
  static const Vector key_direction = unit({-0.55, -0.65, -0.75});  // warm, from the upper left
  static const Vector rim_direction = unit({0.9, 0.15, -0.35});     // cool, from the right
  constexpr Light kAmbient{0.36, 0.37, 0.40};
  constexpr Light kKeyLight{0.80, 0.77, 0.70};
  constexpr Light kRimLight{0.12, 0.15, 0.20};
  const double key = std::max(dot(normal, key_direction), 0.0);
  const double rim = std::max(dot(normal, rim_direction), 0.0);
  Light light{};
  for (std::size_t k = 0; k < light.size(); ++k) {
    light[k] = grey * (kAmbient[k] + key * kKeyLight[k] + rim * kRimLight[k]);
  }
  return light;
}

// From the viewpoint's units to samples of a screen that the whole plate and height field fit.
struct Fit {
  double scale = 1;
  double left = 0;
  double top = 0;
  int width = 0;
  int height = 0;

  Corner operator()(Corner corner, const Light& light) const {
    corner.u = (corner.u - left) * scale;
    corner.v = (corner.v - top) * scale;
    corner.light = light;
    return corner;
  }
};

std::array<Vector, 4> plate(const Field& field) {
  const double margin = kPlateMargin * field.width();
  const double right = field.width() - 1 + margin;
  const double bottom = field.height() - 1 + margin;
  return {field.on_plate(-margin, -margin, kPlateBehind),
          field.on_plate(right, -margin, kPlateBehind), field.on_plate(right, bottom, kPlateBehind),
          field.on_plate(-margin, bottom, kPlateBehind)};
}

Fit fit(const Field& field, const Viewpoint& viewpoint, int width) {
  constexpr double kMargin = 0.02;
  double left = std::numeric_limits<double>::max();
  double top = left;
  double right = -left;
  double bottom = -left;
  const auto include = [&](const Vector& point) {
    const Corner corner = viewpoint.project(point);
    left = std::min(left, corner.u);
    right = std::max(right, corner.u);
    top = std::min(top, corner.v);
    bottom = std::max(bottom, corner.v);
  };
  std::ranges::for_each(plate(field), include);
  for (int y = 0; y < field.height(); ++y) {
    for (int x = 0; x < field.width(); ++x) {
      if (field.there(x, y)) {
        include(field.point(x, y));
      }
    }
  }
  const double margin = kMargin * (right - left);
  const double samples = static_cast<double>(width) * Rasteriser::kSamples;
  const double scale = samples / (right - left + 2 * margin);
  const int rows =
      static_cast<int>(std::lround((bottom - top + 2 * margin) * scale / Rasteriser::kSamples));
  return {.scale = scale,
          .left = left - margin,
          .top = top - margin,
          .width = width * Rasteriser::kSamples,
          .height = std::max(rows, 1) * Rasteriser::kSamples};
}

}  // namespace

dataset::Image<float> smoothed_within(const dataset::Image<float>& disparity, int radius,
                                      float step_px) {
  dataset::Image<float> result = disparity;
  for (int y = 0; y < disparity.height; ++y) {
    for (int x = 0; x < disparity.width; ++x) {
      const float here = disparity.view().at(x, y);
      if (!std::isfinite(here)) {
        continue;
      }
      float sum = 0;
      int count = 0;
      for (int ny = std::max(y - radius, 0); ny <= std::min(y + radius, disparity.height - 1);
           ++ny) {
        for (int nx = std::max(x - radius, 0); nx <= std::min(x + radius, disparity.width - 1);
             ++nx) {
          const float d = disparity.view().at(nx, ny);
          if (std::abs(d - here) <= step_px) {
            sum += d;
            ++count;
          }
        }
      }
      result.view().at(x, y) = sum / static_cast<float>(count);
    }
  }
  return result;
}

dataset::Image<Rgb> height_field_picture(const dataset::Image<float>& disparity,
                                         const dataset::Image<float>& frame, double far_px,
                                         double near_px,
                                         const dataset::Image<std::uint8_t>& texture,
                                         const HeightFieldView& view) {
  constexpr double kPlateGrey = 0.24;
  const double height = std::min(view.height, view.height_a_px * (near_px - far_px));
  const Field field(disparity, far_px, near_px, height);
  const Viewpoint viewpoint(view);
  const Fit place = fit(Field(frame, far_px, near_px, height), viewpoint, view.width);
  Rasteriser screen(place.width, place.height);

  const Light plate_light = lit({0, 0, -1}, kPlateGrey);
  std::array<Corner, 4> base{};
  std::ranges::transform(plate(field), base.begin(), [&](const Vector& point) {
    return place(viewpoint.project(point), plate_light);
  });
  screen.draw({base[0], base[1], base[2]});
  screen.draw({base[0], base[2], base[3]});

  dataset::Image<Corner> corners(field.width(), field.height());
  for (int y = 0; y < field.height(); ++y) {
    for (int x = 0; x < field.width(); ++x) {
      if (field.there(x, y)) {
        const Light light = lit(field.normal(x, y), texture.view().at(x, y) / 255.0);
        corners.view().at(x, y) = place(viewpoint.project(field.point(x, y)), light);
      }
    }
  }
  const auto draw = [&](const std::array<std::pair<int, int>, 3>& at) {
    if (field.joined(at)) {
      screen.draw({corners.view().at(at[0].first, at[0].second),
                   corners.view().at(at[1].first, at[1].second),
                   corners.view().at(at[2].first, at[2].second)});
    }
  };
  for (int y = 0; y + 1 < field.height(); ++y) {
    for (int x = 0; x + 1 < field.width(); ++x) {
      draw({{{x, y}, {x + 1, y}, {x + 1, y + 1}}});
      draw({{{x, y}, {x + 1, y + 1}, {x, y + 1}}});
    }
  }
  return screen.picture();
}

}  // namespace stof::host
