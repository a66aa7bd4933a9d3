#include "hal/emu/scenes/intersect.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

namespace stof::hal::emu {
namespace {

constexpr double kNear = 1e-6;  // nearer hits are the ray's own start

LocalHit rectangle(const Vec3& half, const Vec3& o, const Vec3& d) noexcept {
  if (d.z == 0) {
    return {};
  }
  const double t = -o.z / d.z;
  if (t <= kNear || std::abs(o.x + t * d.x) > half.x || std::abs(o.y + t * d.y) > half.y) {
    return {};
  }
  return {t, {0, 0, d.z > 0 ? -1.0 : 1.0}, 0};
}

LocalHit box(const Vec3& half, const Vec3& o, const Vec3& d) noexcept {
  const std::array<double, 3> origin{o.x, o.y, o.z};
  const std::array<double, 3> direction{d.x, d.y, d.z};
  const std::array<double, 3> size{half.x, half.y, half.z};
  double enter = -std::numeric_limits<double>::infinity();
  double leave = std::numeric_limits<double>::infinity();
  std::size_t axis = 0;
  for (std::size_t i = 0; i < 3; ++i) {
    if (direction[i] == 0) {
      if (std::abs(origin[i]) > size[i]) {
        return {};
      }
      continue;
    }
    const double a = (-size[i] - origin[i]) / direction[i];
    const double b = (size[i] - origin[i]) / direction[i];
    if (std::min(a, b) > enter) {
      enter = std::min(a, b);
      axis = i;
    }
    leave = std::min(leave, std::max(a, b));
  }
  if (enter > leave || enter <= kNear) {
    return {};
  }
  std::array<double, 3> normal{};
  normal[axis] = direction[axis] > 0 ? -1.0 : 1.0;
  return {enter, {normal[0], normal[1], normal[2]}, static_cast<int>(axis)};
}

LocalHit cylinder(const Vec3& half, const Vec3& o, const Vec3& d) noexcept {
  const double ox = o.x / half.x;
  const double oz = o.z / half.z;
  const double dx = d.x / half.x;
  const double dz = d.z / half.z;
  const double a = dx * dx + dz * dz;
  const double b = ox * dx + oz * dz;
  const double root = b * b - a * (ox * ox + oz * oz - 1);
  if (a > 0 && root >= 0) {
    const double t = (-b - std::sqrt(root)) / a;
    if (t > kNear && std::abs(o.y + t * d.y) <= half.y) {
      return {t, unit({(ox + t * dx) / half.x, 0, (oz + t * dz) / half.z}), 0};
    }
  }
  if (d.y == 0) {
    return {};
  }
  const double side = d.y > 0 ? -1.0 : 1.0;  // the cap that faces the ray
  const double t = (side * half.y - o.y) / d.y;
  const double x = ox + t * dx;
  const double z = oz + t * dz;
  if (t <= kNear || x * x + z * z > 1) {
    return {};
  }
  return {t, {0, side, 0}, 1};
}

LocalHit ellipsoid(const Vec3& half, const Vec3& o, const Vec3& d) noexcept {
  const Vec3 origin{o.x / half.x, o.y / half.y, o.z / half.z};
  const Vec3 direction{d.x / half.x, d.y / half.y, d.z / half.z};
  const double a = dot(direction, direction);
  const double b = dot(origin, direction);
  const double root = b * b - a * (dot(origin, origin) - 1);
  if (root < 0) {
    return {};
  }
  const double t = (-b - std::sqrt(root)) / a;
  if (t <= kNear) {
    return {};
  }
  const Vec3 on = origin + t * direction;
  return {t, unit({on.x / half.x, on.y / half.y, on.z / half.z}), 0};
}

}  // namespace

LocalHit intersect(Shape shape, const Vec3& half, const Vec3& origin,
                   const Vec3& direction) noexcept {
  switch (shape) {
    case Shape::kRectangle:
      return rectangle(half, origin, direction);
    case Shape::kBox:
      return box(half, origin, direction);
    case Shape::kCylinder:
      return cylinder(half, origin, direction);
    case Shape::kEllipsoid:
      return ellipsoid(half, origin, direction);
  }
  return {};
}

}  // namespace stof::hal::emu
