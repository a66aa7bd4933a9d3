#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <new>
#include <numbers>
#include <vector>

#include "dsp/calib/pmd/ray_table.h"
#include "dsp/fusion/drift/drift_monitor.h"
#include "tests/support/guarded_part.h"

// A room of textured planes as a stereo pair and a PMD camera see it, without noise, and a monitor
// that looks at it.
namespace stof::dsp {

using Vector = std::array<double, 3>;
using Turn = std::array<double, 9>;

inline constexpr double kRadPerDegree = std::numbers::pi / 180;

// By right-handed angles, about x first.
inline Turn turn_of(double pitch_deg, double yaw_deg, double roll_deg) {
  const auto product = [](const Turn& a, const Turn& b) {
    Turn out{};
    for (std::size_t i = 0; i < 3; ++i) {
      for (std::size_t j = 0; j < 3; ++j) {
        for (std::size_t k = 0; k < 3; ++k) {
          out[3 * i + j] += a[3 * i + k] * b[3 * k + j];
        }
      }
    }
    return out;
  };
  const double cx = std::cos(pitch_deg * kRadPerDegree);
  const double sx = std::sin(pitch_deg * kRadPerDegree);
  const double cy = std::cos(yaw_deg * kRadPerDegree);
  const double sy = std::sin(yaw_deg * kRadPerDegree);
  const double cz = std::cos(roll_deg * kRadPerDegree);
  const double sz = std::sin(roll_deg * kRadPerDegree);
  return product({cz, -sz, 0, sz, cz, 0, 0, 0, 1},
                 product({cy, 0, sy, 0, 1, 0, -sy, 0, cy}, {1, 0, 0, 0, cx, -sx, 0, sx, cx}));
}

// Distance along one axis; what is nearer along a ray hides the others.
struct Wall {
  std::size_t axis;
  double at_m;
};
inline std::vector<Wall> whole_room() {
  return {{1, 0.9}, {0, -1.1}, {0, 1.3}, {2, 4.2}, {1, -1.2}};
}
inline std::vector<Wall> floor_alone() { return {{1, 0.9}}; }

struct Seen {
  double distance_m = 0;  // 0: nothing
  double grey = 0;
};
inline Seen look(const std::vector<Wall>& walls, const Vector& from, const Vector& ray) {
  Seen out;
  Vector point{};
  for (const Wall& wall : walls) {
    const double t = (wall.at_m - from[wall.axis]) / ray[wall.axis];
    if (t > 0 && (out.distance_m == 0 || t < out.distance_m)) {
      out.distance_m = t;
      point = {from[0] + t * ray[0], from[1] + t * ray[1], from[2] + t * ray[2]};
    }
  }
  out.grey = 128;
  const auto wave = [&](double x, double y, double z) {
    return 25 * std::sin(2 * std::numbers::pi * (point[0] / x + point[1] / y + point[2] / z));
  };
  out.grey += wave(0.09, 0.13, 0.31) + wave(-0.17, 0.11, 0.12) + wave(0.4, -0.14, 0.1);
  return out;
}

inline Calibration room_rig() {
  Calibration rig;
  rig.stereo.left = {.width = 320, .height = 240, .fx = 300, .fy = 300, .cx = 160, .cy = 119};
  rig.stereo.baseline_m = 0.15;
  rig.pmd.lens = {
      .width = 88, .height = 72, .fx = 80, .fy = 80, .cx = 44.3, .cy = 35.2, .k1 = -0.05};
  rig.pmd_to_stereo = {turn_of(0.5, -0.7, 0.3), {0.06, -0.05, 0.01}};
  return rig;
}

// What differs from the calibration.
struct RoomDrift {
  double pitch_deg = 0;
  double yaw_deg = 0;
  double roll_deg = 0;
  double range_m = 0;
  double disparity_px = 0;
};

class Room {
 public:
  Room(const std::vector<Wall>& walls, const Calibration& rig, const RoomDrift& drift)
      : width_(rig.stereo.left.width),
        height_(rig.stereo.left.height),
        pmd_width_(rig.pmd.lens.width),
        pmd_height_(rig.pmd.lens.height) {
    see_pair(walls, rig.stereo, drift.disparity_px);
    see_pmd(walls, rig, drift);
  }

  MatchedPair pair() const {
    return {.left = {left.data(), width_, height_},
            .right = {right.data(), width_, height_},
            .disparity = {disparity.data(), width_, height_}};
  }
  PmdMaps maps() {
    PmdMaps out;
    out.distance = {distance.data(), pmd_width_, pmd_height_};
    out.sigma = {sigma.data(), pmd_width_, pmd_height_};
    out.flags = {flags.data(), pmd_width_, pmd_height_};
    return out;
  }

  std::vector<std::uint8_t> left, right;
  std::vector<Disparity> disparity;
  std::vector<QuarterMm> distance, sigma;
  std::vector<std::uint8_t> flags;

 private:
  static std::uint8_t level(double grey) { return static_cast<std::uint8_t>(std::lround(grey)); }

  void see_pair(const std::vector<Wall>& walls, const StereoRig& rig, double offset_px) {
    for (int y = 0; y < height_; ++y) {
      for (int x = 0; x < width_; ++x) {
        const Vector ray{(x - rig.left.cx) / rig.left.fx, (y - rig.left.cy) / rig.left.fy, 1};
        const Vector other{(x + offset_px - rig.left.cx) / rig.left.fx, ray[1], 1};
        const Seen here = look(walls, {}, ray);
        left.push_back(level(here.grey));
        right.push_back(level(look(walls, {rig.baseline_m, 0, 0}, other).grey));
        const double d = rig.left.fx * rig.baseline_m / here.distance_m + offset_px;
        disparity.push_back(
            here.distance_m > 0 && here.distance_m < 50
                ? Disparity::from_raw(static_cast<std::int16_t>(std::lround(d * Disparity::kOne)))
                : Disparity::none());
      }
    }
  }

  void see_pmd(const std::vector<Wall>& walls, const Calibration& rig, const RoomDrift& drift) {
    const Turn turn = turn_of(drift.pitch_deg, drift.yaw_deg, drift.roll_deg);
    const auto turned = [](const Turn& r, const Vector& v) {
      Vector out{};
      for (std::size_t i = 0; i < 3; ++i) {
        out[i] = r[3 * i] * v[0] + r[3 * i + 1] * v[1] + r[3 * i + 2] * v[2];
      }
      return out;
    };
    for (int y = 0; y < pmd_height_; ++y) {
      for (int x = 0; x < pmd_width_; ++x) {
        const Vector ray =
            turned(turn, turned(rig.pmd_to_stereo.rotation, unit_ray(rig.pmd.lens, x, y)));
        const Seen here = look(walls, rig.pmd_to_stereo.translation_m, ray);
        const bool valid = here.distance_m > 0 && here.distance_m < 10;
        distance.push_back(static_cast<QuarterMm>(
            valid ? std::lround((here.distance_m + drift.range_m) * kQuarterMmPerMetre) : 0));
        sigma.push_back(valid ? 40 : 0);
        flags.push_back(valid ? 0 : kPmdLowAmplitude);
      }
    }
  }

  int width_;
  int height_;
  int pmd_width_;
  int pmd_height_;
};

class Watch {
 public:
  explicit Watch(const Calibration& rig, const DriftParams& params = {})
      : owned_([&](Arena& arena) { return DriftMonitor(rig, params, arena); }) {}

 private:
  test::GuardedPart<DriftMonitor> owned_;

 public:
  DriftMonitor& monitor = *owned_;
};

}  // namespace stof::dsp
