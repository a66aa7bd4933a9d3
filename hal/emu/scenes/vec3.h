#pragma once

#include <array>
#include <cmath>

namespace stof::hal::emu {

struct Vec3 {
  double x = 0;
  double y = 0;
  double z = 0;

  friend constexpr Vec3 operator+(const Vec3& a, const Vec3& b) noexcept {
    return {a.x + b.x, a.y + b.y, a.z + b.z};
  }
  friend constexpr Vec3 operator-(const Vec3& a, const Vec3& b) noexcept {
    return {a.x - b.x, a.y - b.y, a.z - b.z};
  }
  friend constexpr Vec3 operator*(double s, const Vec3& a) noexcept {
    return {s * a.x, s * a.y, s * a.z};
  }
};

constexpr double dot(const Vec3& a, const Vec3& b) noexcept {
  return a.x * b.x + a.y * b.y + a.z * b.z;
}
inline double length(const Vec3& a) noexcept { return std::sqrt(dot(a, a)); }
inline Vec3 unit(const Vec3& a) noexcept { return (1 / length(a)) * a; }

// X_outer = rotation X_inner + position; row-major, orthonormal.
struct Pose {
  std::array<double, 9> rotation{1, 0, 0, 0, 1, 0, 0, 0, 1};
  Vec3 position{};

  constexpr Vec3 turn(const Vec3& v) const noexcept {
    const std::array<double, 9>& r = rotation;
    return {r[0] * v.x + r[1] * v.y + r[2] * v.z, r[3] * v.x + r[4] * v.y + r[5] * v.z,
            r[6] * v.x + r[7] * v.y + r[8] * v.z};
  }
  constexpr Vec3 turn_back(const Vec3& v) const noexcept {
    const std::array<double, 9>& r = rotation;
    return {r[0] * v.x + r[3] * v.y + r[6] * v.z, r[1] * v.x + r[4] * v.y + r[7] * v.z,
            r[2] * v.x + r[5] * v.y + r[8] * v.z};
  }
  constexpr Vec3 apply(const Vec3& v) const noexcept { return turn(v) + position; }
  constexpr Vec3 undo(const Vec3& v) const noexcept { return turn_back(v - position); }
};

// a after b: X -> a(b(X)).
constexpr Pose operator*(const Pose& a, const Pose& b) noexcept {
  Pose out;
  for (std::size_t i = 0; i < 3; ++i) {
    for (std::size_t j = 0; j < 3; ++j) {
      out.rotation[3 * i + j] = a.rotation[3 * i] * b.rotation[j] +
                                a.rotation[3 * i + 1] * b.rotation[3 + j] +
                                a.rotation[3 * i + 2] * b.rotation[6 + j];
    }
  }
  out.position = a.apply(b.position);
  return out;
}

// Turns by small or large angles given as sine-free tangents of the half angle, tan(angle / 2), so
// that no transcendental function decides about bits: about y (yaw, to the right), then x (pitch,
// upwards), then z (roll, clockwise).
Pose turned(double yaw_half_tan, double pitch_half_tan = 0, double roll_half_tan = 0) noexcept;
// Takes back what the pose does.
Pose inverse(const Pose& pose) noexcept;
// tan(angle / 2) of an angle in degrees, the same bits on every machine.
double half_tangent(double degrees) noexcept;
inline constexpr double kQuarterTurn = 1;

}  // namespace stof::hal::emu
