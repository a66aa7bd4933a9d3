#include "hal/emu/scenes/rig.h"

#include <cmath>
#include <numbers>

#include <gtest/gtest.h>

#include "hal/emu/imagery/rendered_scene.h"
#include "hal/emu/scenes/viewpoint.h"
#include "tests/hal/scenes/small_rigs.h"

namespace stof::test {
namespace {

using namespace hal::emu;

Rig straight_rig() {
  Rig rig = small(corridor_rig());
  rig.pmd_to_stereo = {};
  return rig;
}

TEST(Misplacement, TurnsUpRightAndClockwiseAboutTheLeftCamerasAxes) {
  const double radian = std::numbers::pi / 180;
  Rig rig = straight_rig();
  rig.misplacement.pitch_degrees = 0.2;
  Vec3 ahead = true_pmd_pose(rig).turn({0, 0, 1});
  EXPECT_NEAR(ahead.y, -std::sin(0.2 * radian), 1e-12);  // y points down
  EXPECT_NEAR(ahead.x, 0, 1e-12);
  rig.misplacement = {.yaw_degrees = 0.2};
  ahead = true_pmd_pose(rig).turn({0, 0, 1});
  EXPECT_NEAR(ahead.x, std::sin(0.2 * radian), 1e-12);
  EXPECT_NEAR(ahead.y, 0, 1e-12);
  rig.misplacement = {.roll_degrees = -0.2};
  EXPECT_NEAR(true_pmd_pose(rig).turn({1, 0, 0}).y, -std::sin(0.2 * radian), 1e-12);
  // Of the left camera: a PMD camera that lies on its side looks up all the same.
  rig.misplacement = {.pitch_degrees = 5};
  rig.pmd_to_stereo.rotation = turned(0, 0, 1).rotation;
  EXPECT_NEAR(true_pmd_pose(rig).turn({0, 0, 1}).y, -std::sin(5 * radian), 1e-12);
}

TEST(Misplacement, IsInTheWorldAndNotInTheCalibration) {
  const Rig rig = small(corridor_rig());
  Rig turned_rig = rig;
  turned_rig.misplacement = {.yaw_degrees = -0.3, .pitch_degrees = 0.5, .roll_degrees = 0.2};
  Rig honest = rig;
  honest.pmd_to_stereo.rotation = true_pmd_pose(turned_rig).rotation;
  const Scene scene = corridor();
  RenderedScene straight(scene, rig);
  RenderedScene misplaced(scene, turned_rig);
  RenderedScene known(scene, honest);
  EXPECT_EQ(misplaced.calibration().pmd_to_stereo.rotation, rig.pmd_to_stereo.rotation);
  EXPECT_EQ(misplaced.calibration().pmd_to_stereo.translation_m, rig.pmd_to_stereo.translation_m);
  EXPECT_EQ(hash(expose(misplaced, 3)), hash(expose(known, 3)));
  EXPECT_NE(hash(expose(misplaced, 3)), hash(expose(straight, 3)));
  EXPECT_EQ(expose(misplaced, 3).left.pixels, expose(straight, 3).left.pixels);
}

// A wall 3 m ahead, 1 m to the right a step to 2 m: a camera turned right by yaw sees the step so
// many pixels further left.
TEST(Misplacement, MovesThePictureByItsAngle) {
  Rig rig = straight_rig();
  rig.left_camera_pose = {};
  rig.pmd_lens = {.width = 80, .height = 3, .fx = 100, .fy = 100, .cx = 39.5, .cy = 1};
  Scene scene = wall(3);
  scene.objects.push_back(
      {.shape = Shape::kRectangle, .pose = {.position = {5, 0, 2}}, .half = {4.8, 3, 0}});
  const auto first_near = [&](const Rig& seen) {  // left edge of the step: x = 0.2 m at 2 m
    const Sensors sensors(seen);
    const CleanViews views = sensors.render(scene);
    for (int x = 0; x < 80; ++x) {
      const Decoded d = decode(sensors.calibration().pmd, clean_samples(views.pmd, x, 1),
                               static_cast<std::size_t>(80 + x));
      if (d.turns * 7.4948 < 2.3) {
        return x;
      }
    }
    return -1;
  };
  EXPECT_EQ(first_near(rig), 50);    // 39.5 + 100 * 0.1, mixed before
  rig.misplacement.yaw_degrees = 3;  // 5.2 px
  EXPECT_NEAR(first_near(rig), 45, 1);
}

TEST(Misplacement, RangeOffsetIsWhatIsMeasuredTooMuch) {
  Rig rig = straight_rig();
  rig.left_camera_pose = {};
  rig.pmd.kappa3 = 0;
  rig.pmd.kappa5 = 0;
  for (const double offset : {-0.05, 0.03}) {
    rig.misplacement.range_offset_m = offset;
    const Sensors sensors(rig);
    const CleanViews views = sensors.render(wall(2.5));
    const dsp::PmdSensor& sensor = sensors.calibration().pmd;
    const Vec3 ray = undistorted_ray(rig.pmd_lens, 22, 18);
    const std::size_t at = static_cast<std::size_t>(18 * rig.pmd_lens.width + 22);
    const Decoded decoded = decode(sensor, clean_samples(views.pmd, 22, 18), at);
    EXPECT_NEAR(range_error(sensor, decoded, 2.5 * length(ray)), offset, 0.001);
    EXPECT_EQ(sensor.frequency.offset_m, 0);
  }
}

TEST(Resize, KeepsTheWidthOfTheField) {
  for (const int width : {64, 320, 1280}) {
    Rig rig = corridor_rig();
    const dsp::Pinhole before = rig.stereo.left;
    const dsp::Pinhole pmd_before = rig.pmd_lens;
    resize_stereo(rig, width, width / 2);
    resize_pmd(rig, width / 4, 16);
    const auto left_edge = [](const dsp::Pinhole& lens) { return (-0.5 - lens.cx) / lens.fx; };
    const auto right_edge = [](const dsp::Pinhole& lens) {
      return (lens.width - 0.5 - lens.cx) / lens.fx;
    };
    EXPECT_NEAR(left_edge(rig.stereo.left), left_edge(before), 1e-12);
    EXPECT_NEAR(right_edge(rig.stereo.left), right_edge(before), 1e-12);
    EXPECT_NEAR(left_edge(rig.pmd_lens), left_edge(pmd_before), 1e-12);
    EXPECT_EQ(rig.stereo.left.fx, rig.stereo.left.fy);
    EXPECT_EQ(rig.pmd_lens.height, 16);
    EXPECT_GE(rig.disparities * 640, 64 * width);
    EXPECT_LT(rig.disparities * 640, 64 * width + 8 * 640);
  }
}

}  // namespace
}  // namespace stof::test
