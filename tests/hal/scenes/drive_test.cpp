#include "hal/emu/scenes/drive.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include <gtest/gtest.h>

#include "hal/emu/imagery/driven_scene.h"
#include "hal/emu/imagery/rendered_scene.h"
#include "tests/hal/scenes/small_rigs.h"

namespace stof::test {
namespace {

using namespace hal::emu;

constexpr double kStepS = 0.001;

DrivenScene small_drive(double speed, const ExposureTimes& times = {}) {
  return {corridor(), small(corridor_rig()), speed, times};
}

double turned_degrees(const Pose& a, const Pose& b) {
  const Vec3 ahead{0, 0, 1};
  return std::acos(std::min(1.0, dot(a.turn(ahead), b.turn(ahead)))) * 180 / std::numbers::pi;
}

TEST(Drive, ReachesItsSpeedAndTurningRateAndNoMore) {
  const Pose start = corridor_rig().left_camera_pose;
  for (const double speed : {0.5, 1.0, 1.5}) {
    double fastest = 0;
    double most_turning = 0;
    for (int i = 0; i < 6000; ++i) {
      const Pose a = drive(start, speed, i * kStepS);
      const Pose b = drive(start, speed, (i + 1) * kStepS);
      fastest = std::max(fastest, std::abs(b.position.z - a.position.z) / kStepS);
      most_turning = std::max(most_turning, turned_degrees(a, b) / kStepS);
    }
    EXPECT_NEAR(fastest, speed, 0.001);
    // Bumps turn it, too: up to 12.6 degrees a second, upwards.
    EXPECT_GT(most_turning, 40 * speed - 0.1);
    EXPECT_LT(most_turning, 45 * speed);
  }
}

TEST(Drive, BeginsWhereTheRigStandsAndComesBack) {
  const Pose start = hall_rig().left_camera_pose;
  for (const double seconds : {0.0, 6.0, 60.0}) {
    EXPECT_NEAR(length(drive(start, 1.5, seconds).position - start.position), 0, 1e-9);
    EXPECT_NEAR(turned_degrees(drive(start, 1.5, seconds), start), 0, 1e-4);
  }
}

// A rig that looks from another place at the scene sees the same as one that drove there.
TEST(DrivenScene, ShowsWhatTheRigWouldSeeFromThere) {
  DrivenScene driven = small_drive(1);
  for (const std::uint32_t number : {40U, 3U}) {
    Rig rig = small(corridor_rig());
    rig.left_camera_pose = drive(rig.left_camera_pose, 1, number / 30.0 + 0.002);
    RenderedScene still(corridor(), rig);
    const Exposed there = expose(still, number);
    const Exposed moved = expose(driven, number);
    std::size_t different = 0;
    for (std::size_t i = 0; i < there.left.pixels.size(); ++i) {
      different += std::abs(there.left.pixels[i] - moved.left.pixels[i]) > 1 ? 1U : 0U;
      EXPECT_NEAR(driven.depth(number).pixels[i], still.depth().pixels[i], 1e-3) << i;
      i += 96;
    }
    EXPECT_LT(different, 3U);
  }
}

TEST(DrivenScene, SamplesOfOneExposureSeeFourPlaces) {
  DrivenScene at_once = small_drive(1.5, {.pmd = 0});
  DrivenScene later = small_drive(1.5, {.pmd = 0.016});
  const Exposed first = expose(at_once, 5);
  const Exposed second = expose(later, 5);
  EXPECT_EQ(first.left.pixels, second.left.pixels);
  const auto apart = [&](std::size_t k) {
    int sum = 0;
    for (std::size_t i = 0; i < first.samples[k].pixels.size(); ++i) {
      sum += std::abs(first.samples[k].pixels[i] - second.samples[k].pixels[i]);
    }
    return sum;
  };
  EXPECT_GT(apart(0), 0);
  EXPECT_GT(apart(3), 2 * apart(0));
}

TEST(DrivenScene, ThatStandsIsTheSceneAsItIs) {
  DrivenScene standing = small_drive(0);
  RenderedScene still(corridor(), small(corridor_rig()));
  EXPECT_EQ(hash(expose(standing, 9)), hash(expose(still, 9)));
  EXPECT_EQ(standing.visible(9).pixels, still.visible().pixels);
}

// A sparse PMD camera exposes at its own edges.
TEST(DrivenScene, SparsePmdCameraSeesThePlaceOfItsOwnEdge) {
  DrivenScene every = small_drive(1);
  DrivenScene sparse = small_drive(1, {.pmd_every = 4});
  const auto distance = [](DrivenScene& a, std::uint32_t n, DrivenScene& b, std::uint32_t m) {
    const Exposed x = expose(a, n);
    const Exposed y = expose(b, m);
    int sum = 0;
    for (std::size_t i = 0; i < x.samples[0].pixels.size(); ++i) {
      sum += std::abs(x.samples[0].pixels[i] - y.samples[0].pixels[i]);
    }
    return sum;
  };
  // Exposure 3 of every fourth edge is that of edge 9; only the noise differs.
  EXPECT_LT(distance(sparse, 3, every, 9), distance(sparse, 3, every, 3));
}

}  // namespace
}  // namespace stof::test
