#pragma once

#include <array>
#include <cstddef>

#include <Eigen/Geometry>

#include "dsp/calib/pinhole.h"

// Lenses and poses as arrays of unknowns, for fits: projection in any number type.
namespace stof::host {

// fx fy cx cy k1 k2 p1 p2 k3, OpenCV's order.
inline constexpr std::size_t kLensUnknowns = 9;
using LensUnknowns = std::array<double, kLensUnknowns>;
inline constexpr std::array<const char*, kLensUnknowns> kLensNames{"fx", "fy", "cx", "cy", "k1",
                                                                   "k2", "p1", "p2", "k3"};

// A rotation vector (axis times angle, rad) and a translation (m): X' = R X + T.
inline constexpr std::size_t kPoseUnknowns = 6;
using PoseUnknowns = std::array<double, kPoseUnknowns>;

inline LensUnknowns unknowns_of(const dsp::Pinhole& lens) {
  return {lens.fx, lens.fy, lens.cx, lens.cy, lens.k1, lens.k2, lens.p1, lens.p2, lens.k3};
}

inline void put_unknowns(const LensUnknowns& x, dsp::Pinhole& lens) {
  lens.fx = x[0];
  lens.fy = x[1];
  lens.cx = x[2];
  lens.cy = x[3];
  lens.k1 = x[4];
  lens.k2 = x[5];
  lens.p1 = x[6];
  lens.p2 = x[7];
  lens.k3 = x[8];
}

using Matrix3 = Eigen::Matrix3d;
using Vector3 = Eigen::Vector3d;

inline Matrix3 rotation_of(const PoseUnknowns& pose) {
  const Vector3 turn(pose[0], pose[1], pose[2]);
  const double angle = turn.norm();
  return angle == 0 ? Matrix3(Matrix3::Identity())
                    : Matrix3(Eigen::AngleAxisd(angle, turn / angle).toRotationMatrix());
}

inline Vector3 translation_of(const PoseUnknowns& pose) { return {pose[3], pose[4], pose[5]}; }

inline PoseUnknowns pose_of(const Matrix3& rotation, const Vector3& translation) {
  const Eigen::AngleAxisd turn(rotation);
  const Vector3 vector = turn.angle() * turn.axis();
  return {vector.x(), vector.y(), vector.z(), translation.x(), translation.y(), translation.z()};
}

inline dsp::RigidTransform transform_of(const PoseUnknowns& pose) {
  dsp::RigidTransform transform;
  Eigen::Map<Eigen::Matrix<double, 3, 3, Eigen::RowMajor>>(transform.rotation.data()) =
      rotation_of(pose);
  Eigen::Map<Vector3>(transform.translation_m.data()) = translation_of(pose);
  return transform;
}

inline PoseUnknowns pose_of(const dsp::RigidTransform& transform) {
  const Matrix3 rotation =
      Eigen::Map<const Eigen::Matrix<double, 3, 3, Eigen::RowMajor>>(transform.rotation.data());
  return pose_of(Eigen::Quaterniond(rotation).normalized().toRotationMatrix(),
                 Eigen::Map<const Vector3>(transform.translation_m.data()));
}

// Brown's distortion of dsp::Pinhole, then pixels. False where the point is not before the camera.
template <typename T>
bool project(const T* lens, const std::array<T, 3>& point, std::array<T, 2>& pixel) {
  if (!(point[2] > T(1e-6))) {
    return false;
  }
  const T x = point[0] / point[2];
  const T y = point[1] / point[2];
  const T r2 = x * x + y * y;
  const T stretch = T(1) + r2 * (lens[4] + r2 * (lens[5] + r2 * lens[8]));
  pixel[0] =
      lens[0] * (x * stretch + T(2) * lens[6] * x * y + lens[7] * (r2 + T(2) * x * x)) + lens[2];
  pixel[1] =
      lens[1] * (y * stretch + lens[6] * (r2 + T(2) * y * y) + T(2) * lens[7] * x * y) + lens[3];
  return true;
}

}  // namespace stof::host
