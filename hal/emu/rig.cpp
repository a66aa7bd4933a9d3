#include "hal/emu/rig.h"

namespace stof::hal::emu {
namespace {

// Tangents of the half angles.
constexpr double kHalfDegree = 0.0087268677907587;    // of 1 degree
constexpr double kThreeDegrees = 0.0261859215691869;  // of 3 degrees
constexpr double kThirdOfDegree = 0.0026179998696;    // of 0.3 degrees

}  // namespace

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
  rig.head = turned(-kThreeDegrees, -kThreeDegrees);
  rig.head.position = {0, -1.0, 0};
  return rig;
}

}  // namespace stof::hal::emu
