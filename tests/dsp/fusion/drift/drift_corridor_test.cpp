#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <numbers>
#include <vector>

#include <gtest/gtest.h>

#include "dsp/fusion/drift/drift_monitor.h"
#include "dsp/pmd/converter.h"
#include "dsp/stereo/matcher.h"
#include "hal/emu/imagery/rendered_scene.h"
#include "tests/support/guarded_part.h"

// The whole way: rendered exposures with noise, the matcher, the converter, the monitor->
namespace stof::dsp {
namespace {

constexpr int kFrames = 48;
constexpr double kDegrees = 180e-6 / std::numbers::pi;  // of a micro-radian

DriftEstimate watch_corridor(const hal::emu::Misplacement& misplacement) {
  hal::emu::Rig rig = hal::emu::corridor_rig();
  rig.misplacement = misplacement;
  hal::emu::RenderedScene world(hal::emu::corridor(), rig);
  const auto [width, height] = world.stereo_size();
  const auto [pmd_width, pmd_height] = world.pmd_size();
  MatchParams params = find_preset("fast")->params;
  params.disparities = world.disparities();
  test::GuardedPart<Matcher> matcher(
      [&, w = width, h = height](Arena& arena) { return Matcher(params, w, h, arena); });
  const Calibration& calibration = world.calibration();
  test::GuardedPart<PmdConverter> converter(
      [&](Arena& arena) { return PmdConverter(calibration.pmd, arena); });
  test::GuardedPart<DriftMonitor> monitor(
      [&](Arena& arena) { return DriftMonitor(calibration, {}, arena); });

  dataset::Image<std::uint8_t> left(width, height);
  dataset::Image<std::uint8_t> right(width, height);
  std::vector<Disparity> disparities(static_cast<std::size_t>(width * height));
  const ImageView<Disparity> disparity(disparities.data(), width, height);
  std::array<dataset::Image<std::uint16_t>, 4> samples;
  for (std::uint32_t frame = 1; frame <= kFrames; ++frame) {
    world.left(frame, left.view());
    world.right(frame, right.view());
    PmdSamples views;
    for (std::size_t k = 0; k < 4; ++k) {
      samples[k] = {pmd_width, pmd_height};
      world.pmd(frame, static_cast<int>(k), samples[k].view());
      views[k] = samples[k].view();
    }
    matcher->match({.left = left.view(), .right = right.view()}, disparity);
    monitor->observe({.left = left.view(), .right = right.view(), .disparity = disparity},
                     converter->convert(views));
  }
  return monitor->estimate();
}

// 48 frames, a second and a half: a minute's noise is a third of this one's.
TEST(DriftInTheCorridor, FindsATurnedPmdCamera) {
  const DriftEstimate found = watch_corridor({.yaw_degrees = -0.2, .pitch_degrees = 0.2});
  EXPECT_TRUE(found.significant);
  EXPECT_TRUE(found[DriftParameter::kPitch].significant);
  EXPECT_TRUE(found[DriftParameter::kYaw].significant);
  EXPECT_NEAR(found[DriftParameter::kPitch].value * kDegrees, 0.2, 0.06);
  EXPECT_NEAR(found[DriftParameter::kYaw].value * kDegrees, -0.2, 0.06);
}

TEST(DriftInTheCorridor, FindsNothingWhereNothingTurned) {
  const DriftEstimate found = watch_corridor({});
  EXPECT_FALSE(found.significant);
  EXPECT_GE(found.patches, 50U);
}

}  // namespace
}  // namespace stof::dsp
