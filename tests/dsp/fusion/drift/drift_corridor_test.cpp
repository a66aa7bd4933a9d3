#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <numbers>
#include <vector>

#include <gtest/gtest.h>

#include "dsp/fusion/drift/drift_monitor.h"
#include "dsp/pmd/converter.h"
#include "dsp/stereo/matcher.h"
#include "hal/emu/imagery/driven_scene.h"
#include "hal/emu/imagery/imagery.h"
#include "hal/emu/imagery/rendered_scene.h"
#include "hal/emu/scenes/scene.h"
#include "tests/support/guarded_part.h"

// The whole way: rendered exposures with noise, the matcher, the converter, the monitor->
namespace stof::dsp {
namespace {

constexpr int kFrames = 48;
constexpr double kDegrees = 180e-6 / std::numbers::pi;  // of a micro-radian

// What the cameras of a world give, exposure by exposure.
class Exposures {
 public:
  explicit Exposures(const hal::emu::Imagery& world)
      : left(world.stereo_size().width, world.stereo_size().height),
        right(left.width, left.height),
        disparities_(static_cast<std::size_t>(left.width * left.height)) {
    samples_.fill({world.pmd_size().width, world.pmd_size().height});
  }
  PmdSamples take(hal::emu::Imagery& world, std::uint32_t number) {
    world.left(number, left.view());
    world.right(number, right.view());
    PmdSamples views;
    for (std::size_t k = 0; k < views.size(); ++k) {
      world.pmd(number, static_cast<int>(k), samples_[k].view());
      views[k] = samples_[k].view();
    }
    return views;
  }
  ImageView<Disparity> disparity() { return {disparities_.data(), left.width, left.height}; }
  MatchedPair pair() {
    return {.left = left.view(), .right = right.view(), .disparity = disparity()};
  }

  dataset::Image<std::uint8_t> left;
  dataset::Image<std::uint8_t> right;

 private:
  std::vector<Disparity> disparities_;
  std::array<dataset::Image<std::uint16_t>, 4> samples_;
};

DriftEstimate watch_corridor(const hal::emu::Misplacement& misplacement) {
  hal::emu::Rig rig = hal::emu::corridor_rig();
  rig.misplacement = misplacement;
  hal::emu::RenderedScene world(hal::emu::corridor(), rig);
  const auto [width, height] = world.stereo_size();
  MatchParams params = find_preset("fast")->params;
  params.disparities = world.disparities();
  test::GuardedPart<Matcher> matcher(
      [&, w = width, h = height](Arena& arena) { return Matcher(params, w, h, arena); });
  const Calibration& calibration = world.calibration();
  test::GuardedPart<PmdConverter> converter(
      [&](Arena& arena) { return PmdConverter(calibration.pmd, arena); });
  test::GuardedPart<DriftMonitor> monitor(
      [&](Arena& arena) { return DriftMonitor(calibration, {}, arena); });
  Exposures exposures(world);
  for (std::uint32_t frame = 1; frame <= kFrames; ++frame) {
    const PmdSamples views = exposures.take(world, frame);
    matcher->match({.left = exposures.left.view(), .right = exposures.right.view()},
                   exposures.disparity());
    monitor->observe(exposures.pair(), converter->convert(views));
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

// The calibration of a PMD camera that was turned to the right by so much since: the same as a rig
// that is as it was, and a calibration that is turned back.
Calibration turned_back(Calibration calibration, double yaw_degrees) {
  const double turn = -yaw_degrees * std::numbers::pi / 180;
  const double c = std::cos(turn);
  const double s = std::sin(turn);
  const std::array<double, 9> old = calibration.pmd_to_stereo.rotation;
  std::array<double, 9>& rotation = calibration.pmd_to_stereo.rotation;
  for (std::size_t column = 0; column < 3; ++column) {
    rotation[column] = c * old[column] + s * old[6 + column];
    rotation[6 + column] = c * old[6 + column] - s * old[column];
  }
  return calibration;
}

// Two seconds at a metre a second, with turns of up to 40 degrees a second and bumps: in the 6 ms
// between both exposures the rig turns by up to a quarter of a degree.
TEST(DriftInTheCorridor, NamesATurnWhileTheRigDrivesAndNothingElse) {
  constexpr std::uint32_t kDriven = 64;
  constexpr std::int32_t kPeriodUs = 33'333;
  constexpr std::int32_t kLagUs = 6'000;
  hal::emu::Rig rig = hal::emu::corridor_rig();
  hal::emu::resize_stereo(rig, 320, 240);
  rig.pmd.rays_per_side = 2;  // a quarter of the time
  hal::emu::DrivenScene world(hal::emu::corridor(), rig, 1, {});
  MatchParams params = find_preset("fast")->params;
  params.disparities = world.disparities();
  test::GuardedPart<Matcher> matcher(
      [&](Arena& arena) { return Matcher(params, 320, 240, arena); });
  const Calibration& calibration = world.calibration();
  const Calibration other = turned_back(calibration, 0.5);
  test::GuardedPart<PmdConverter> converter(
      [&](Arena& arena) { return PmdConverter(calibration.pmd, arena); });
  test::GuardedPart<DriftMonitor> good(
      [&](Arena& arena) { return DriftMonitor(calibration, {}, arena); });
  test::GuardedPart<DriftMonitor> turned(
      [&](Arena& arena) { return DriftMonitor(other, {}, arena); });
  Exposures exposures(world);
  for (std::uint32_t frame = 1; frame <= kDriven; ++frame) {
    const PmdSamples views = exposures.take(world, frame);
    matcher->match({.left = exposures.left.view(), .right = exposures.right.view()},
                   exposures.disparity());
    const PmdMaps& maps = converter->convert(views);
    for (DriftMonitor* const monitor : {&*good, &*turned}) {
      monitor->follow(exposures.left.view(), frame == 1 ? 0 : kPeriodUs);
      monitor->observe(exposures.pair(), maps, kLagUs);
    }
  }
  const DriftEstimate none = good->estimate();
  EXPECT_FALSE(none.significant);
  EXPECT_NE(none[DriftParameter::kYaw].sigma, kDriftUnknown);
  const DriftEstimate found = turned->estimate();
  for (std::size_t k = 0; k < kDriftParameters; ++k) {
    EXPECT_EQ(found.drifts[k].significant, k == static_cast<std::size_t>(DriftParameter::kYaw))
        << k << ": " << found.drifts[k].value << " +- " << found.drifts[k].sigma;
  }
  EXPECT_NEAR(found[DriftParameter::kYaw].value * kDegrees, 0.5, 0.25);
}

}  // namespace
}  // namespace stof::dsp
