#include "hal/emu/scenes/rig.h"

#include <cmath>

namespace stof::hal::emu {
namespace {

// Tangents of the half angles.
constexpr double kHalfDegree = 0.0087268677907587;    // of 1 degree
constexpr double kThreeDegrees = 0.0261859215691869;  // of 3 degrees
constexpr double kThirdOfDegree = 0.0026179998696;    // of 0.3 degrees

void resize(dsp::Pinhole& lens, int width, int height) noexcept {
  const double scale = static_cast<double>(width) / lens.width;
  // Pixel centres have integer coordinates: the picture's middle is at (size - 1) / 2.
  lens.cx = (width - 1) / 2.0 + scale * (lens.cx - (lens.width - 1) / 2.0);
  lens.cy = (height - 1) / 2.0 + scale * (lens.cy - (lens.height - 1) / 2.0);
  lens.fx *= scale;
  lens.fy *= scale;
  lens.width = width;
  lens.height = height;
}

}  // namespace

Pose true_pmd_pose(const Rig& rig) noexcept {
  const std::array<double, 3>& t = rig.pmd_to_stereo.translation_m;
  const Misplacement& m = rig.misplacement;
  const Pose turn = turned(half_tangent(m.yaw_degrees), half_tangent(m.pitch_degrees),
                           half_tangent(m.roll_degrees));
  Pose out = turn * Pose{.rotation = rig.pmd_to_stereo.rotation, .position = {}};
  out.position = {t[0], t[1], t[2]};
  return out;
}

void resize_stereo(Rig& rig, int width, int height) noexcept {
  constexpr int kStep = 8;  // ranges are multiples of it
  const double scale = static_cast<double>(width) / rig.stereo.left.width;
  resize(rig.stereo.left, width, height);
  rig.stereo.doff_px *= scale;
  rig.disparities = static_cast<int>(std::ceil(rig.disparities * scale / kStep)) * kStep;
}

void resize_pmd(Rig& rig, int width, int height) noexcept { resize(rig.pmd_lens, width, height); }

Rig corridor_rig() {
  Rig rig;
  rig.stereo = {
      .left = {.width = 640, .height = 480, .fx = 615, .fy = 615, .cx = 319.5, .cy = 239.5},
      .baseline_m = 0.12,
      .doff_px = 0};
  rig.disparities = 64;
  rig.pmd_lens = {.width = 176,
                  .height = 144,
                  .fx = 158.8,
                  .fy = 158.8,
                  .cx = 88.3,
                  .cy = 70.9,
                  .k1 = -0.06,
                  .k2 = 0};
  rig.pmd_to_stereo.rotation = turned(kHalfDegree, -kHalfDegree / 2, kThirdOfDegree).rotation;
  rig.pmd_to_stereo.translation_m = {0.06, -0.04, 0.01};
  rig.left_camera_pose = turned(-kThreeDegrees, -kThreeDegrees);
  rig.left_camera_pose.position = {0, -1.0, 0};
  return rig;
}

Rig hall_rig() {
  constexpr double kTwoDegrees = 0.0174550649282176;
  Rig rig = corridor_rig();
  rig.stereo.baseline_m = 0.25;
  rig.disparities = 96;
  rig.pmd_to_stereo.translation_m = {0.125, -0.06, 0.01};
  rig.left_camera_pose = turned(0, -kTwoDegrees);
  rig.left_camera_pose.position = {0, -1.5, 0};
  rig.pmd.signal_e = 10'000'000;
  rig.pmd.contrast = 0.6;
  rig.pmd.ambient_e = 3'000;
  rig.pmd.suppression = 0.98;
  rig.pmd.residual_e = 50;
  rig.pmd.read_noise_e = 50;
  rig.pmd.electrons_per_lsb = 130;
  rig.pmd.bits = 15;
  return rig;
}

}  // namespace stof::hal::emu
