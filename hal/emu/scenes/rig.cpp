#include "hal/emu/scenes/rig.h"

#include <cmath>

#include "dsp/calib/stereo/rectification.h"

namespace stof::hal::emu {
namespace {

// Tangents of the half angles.
constexpr double kHalfDegree = 0.0087268677907587;    // of 1 degree
constexpr double kThreeDegrees = 0.0261859215691869;  // of 3 degrees
constexpr double kThirdOfDegree = 0.0026179998696;    // of 0.3 degrees

constexpr double kRadPerDegree = 3.14159265358979323846 / 180;

// Yaws of a converging pair count towards the left.
Eye converging_eye(const dsp::Pinhole& left, double yaw_rad, double focal_m, double pixel_m,
                   double cx) noexcept {
  dsp::Pinhole lens = left;
  lens.fx = lens.fy = focal_m / pixel_m;
  lens.cx = cx;
  return {.lens = lens, .pose = turned(half_tangent(-yaw_rad / kRadPerDegree))};
}

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

Eye left_eye(const Rig& rig) noexcept {
  const dsp::StereoRig& stereo = rig.stereo;
  if (stereo.raw) {
    // Which way the axes are turned is a choice that dsp/calib has made.
    const Pose turn{.rotation = dsp::rectify(*stereo.raw).left_turn, .position = {}};
    return {.lens = stereo.raw->left, .pose = turn};
  }
  if (const auto& c = stereo.converging) {
    return converging_eye(stereo.left, c->beta_rad, c->f2_m, c->pixel_m, c->cx_left);
  }
  return {.lens = stereo.left};
}

Eye right_eye(const Rig& rig) noexcept {
  const dsp::StereoRig& stereo = rig.stereo;
  if (stereo.raw) {
    const dsp::RigidTransform& t = stereo.raw->left_to_right;
    const Pose to_right{.rotation = t.rotation,
                        .position = {t.translation_m[0], t.translation_m[1], t.translation_m[2]}};
    return {.lens = stereo.raw->right, .pose = left_eye(rig).pose * inverse(to_right)};
  }
  if (const auto& c = stereo.converging) {
    Eye eye = converging_eye(stereo.left, c->alpha_rad, c->f1_m, c->pixel_m, c->cx_right);
    eye.pose.position = {stereo.baseline_m, 0, 0};
    return eye;
  }
  Eye eye{.lens = stereo.left, .pose = {.position = {stereo.baseline_m, 0, 0}}};
  eye.lens.cx += stereo.doff_px;
  return eye;
}

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
  if (rig.stereo.raw) {
    resize(rig.stereo.raw->left, width, height);
    resize(rig.stereo.raw->right, width, height);
  }
  if (auto& c = rig.stereo.converging) {
    c->pixel_m /= scale;
    const auto resized = [&](double cx) {
      return (width - 1) / 2.0 + scale * (cx - (width / scale - 1) / 2.0);
    };
    c->cx_left = resized(c->cx_left);
    c->cx_right = resized(c->cx_right);
  }
  if (rig.stereo.raw || rig.stereo.converging) {
    dsp::complete(rig.stereo);
  }
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

Rig chapter_rig() {
  constexpr double kMeetM = 4;
  Rig rig = corridor_rig();
  rig.left_camera_pose = {};
  const double yaw = std::atan(0.10 / kMeetM);
  rig.stereo.baseline_m = 0.20;
  rig.stereo.left.fy = 8.5e-3 / 5.6e-6;
  rig.stereo.converging = dsp::Converging{.alpha_rad = yaw,
                                          .beta_rad = -yaw,
                                          .f1_m = 8.5e-3,
                                          .f2_m = 8.5e-3,
                                          .pixel_m = 5.6e-6,
                                          .cx_left = 319.5,
                                          .cx_right = 319.5};
  dsp::complete(rig.stereo);
  rig.disparities = 128;
  rig.pmd_lens = {.width = 64,
                  .height = 16,
                  .fx = 45.28,
                  .fy = 45.28,
                  .cx = 31.5 + 1.3,
                  .cy = 7.5 + 2.5,
                  .k1 = -0.1};
  rig.pmd_to_stereo.translation_m = {0.10, -0.06, 0.01};
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
