#include "dsp/pmd/phase/motion_correction.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include <gtest/gtest.h>

#include "tests/dsp/pmd/converter_rig.h"
#include "tests/support/random.h"

namespace stof::dsp {
namespace {

constexpr int kColumns = 80;
constexpr int kRows = 64;
constexpr double kDistance = 2.7;
constexpr double kLight = 1500;
constexpr double kAmplitude = 500;
constexpr int kTruth = static_cast<int>(kDistance * kQuarterMmPerMetre);

PmdSensor sensor() {
  PmdSensor sensor;
  sensor.lens = {.width = kColumns, .height = kRows, .fx = 90, .fy = 90, .cx = 39.5, .cy = 31.5};
  sensor.dark_lsb = 100;
  sensor.electrons_per_lsb = 61;
  sensor.noise_lsb = 5;
  return sensor;
}

// A wall whose brightness changes by `change` LSB from sample to sample, left of column `until`.
Planes wall(double change, int until = kColumns) {
  Planes planes(kColumns, kRows);
  planes.show_everywhere(kDistance, kLight, kAmplitude);
  for (std::size_t k = 0; k < 4; ++k) {
    for (std::size_t i = 0; i < planes.planes[k].size(); ++i) {
      const bool moves = static_cast<int>(i) % kColumns < until;
      const double more = moves ? std::round(change * (static_cast<double>(k) - 1.5)) : 0;
      planes.planes[k][i] = static_cast<std::uint16_t>(planes.planes[k][i] + more);
    }
  }
  return planes;
}

// Noise of samples as the sensor's calibration has it.
void add_noise(Planes& planes, std::uint64_t seed) {
  test::Random random(seed);
  constexpr int kDice = 12;  // of variance 1 / 12 each
  for (std::vector<std::uint16_t>& plane : planes.planes) {
    for (std::uint16_t& value : plane) {
      double sum = 0;
      for (int i = 0; i < kDice; ++i) {
        sum += random.between(0, 10000) / 10000.0 - 0.5;
      }
      const double sigma = std::sqrt((value - 100) / 61.0 + 25);
      value = static_cast<std::uint16_t>(std::lround(value + sigma * sum));
    }
  }
}

TEST(MotionCorrection, ReadsAWallWhoseBrightnessChangesBetweenTheSamples) {
  for (const double change : {60.0, -60.0}) {
    ConverterRig rig(sensor());
    const Planes planes = wall(change);
    const PmdMaps& maps = rig.converter().convert(planes.samples());
    EXPECT_TRUE(maps.moved);
    for (int y = 0; y < kRows; ++y) {
      for (int x = 0; x < kColumns; ++x) {
        ASSERT_EQ(maps.flags.at(x, y) & kPmdMissing, 0);
        // One sigma of the uneven sums stays: 0.1 m of some 0.3.
        ASSERT_NEAR(maps.distance.at(x, y), kTruth, 500);
        ASSERT_LE(maps.low.at(x, y), kTruth);
        ASSERT_GE(maps.high.at(x, y), kTruth);
        ASSERT_NEAR(maps.amp2.at(x, y), 2 * kAmplitude, 25);
        ASSERT_NEAR(maps.offset.at(x, y), kLight, 2);
      }
    }
  }
}

TEST(MotionCorrection, SaysInSigmaWhatItTookAway) {
  const auto sigma_at = [](double change) {
    ConverterRig rig(sensor());
    const Planes planes = wall(change);
    return rig.converter().convert(planes.samples()).sigma.at(20, 20);
  };
  const int still = sigma_at(0);
  const int slow = sigma_at(60);
  const int fast = sigma_at(120);
  EXPECT_GT(slow, still * 3 / 2);
  EXPECT_GT(fast, slow * 3 / 2);
}

TEST(MotionCorrection, StandingSceneHasNone) {
  for (const std::uint64_t seed : {1U, 2U, 3U}) {
    ConverterRig rig(sensor());
    Planes planes = wall(0);
    add_noise(planes, seed);
    EXPECT_FALSE(rig.converter().convert(planes.samples()).moved) << seed;
  }
}

// What moves at one side changes no bit at the other.
TEST(MotionCorrection, FarFromWhatMovesNoBitChanges) {
  Planes still = wall(0);
  Planes moving = wall(60, 16);
  add_noise(still, 4);
  add_noise(moving, 4);
  for (std::size_t k = 0; k < 4; ++k) {  // noise depends on the brightness
    for (std::size_t i = 0; i < still.planes[k].size(); ++i) {
      if (static_cast<int>(i) % kColumns >= 16) {
        moving.planes[k][i] = still.planes[k][i];
      }
    }
  }
  ConverterRig one(sensor());
  ConverterRig other(sensor());
  const PmdMaps& a = one.converter().convert(still.samples());
  const PmdMaps& b = other.converter().convert(moving.samples());
  EXPECT_FALSE(a.moved);
  EXPECT_TRUE(b.moved);
  int changed = 0;
  for (int y = 0; y < kRows; ++y) {
    for (int x = 0; x < kColumns; ++x) {
      const bool same =
          a.phase.at(x, y) == b.phase.at(x, y) && a.sigma.at(x, y) == b.sigma.at(x, y);
      EXPECT_TRUE(same || x < 32) << x << ", " << y;  // the next cell is near
      changed += !same && x >= 16 && x < 32 ? 1 : 0;
    }
  }
  EXPECT_GT(changed, 100);
}

// The frame after one that moved stands still again.
TEST(MotionCorrection, DoesNotOutlastItsFrame) {
  ConverterRig fresh(sensor());
  ConverterRig used(sensor());
  const Planes still = wall(0);
  const Planes moving = wall(60);
  used.converter().convert(moving.samples());
  const PmdMaps& a = fresh.converter().convert(still.samples());
  const PmdMaps& b = used.converter().convert(still.samples());
  EXPECT_FALSE(b.moved);
  for (int y = 0; y < kRows; ++y) {
    EXPECT_TRUE(std::ranges::equal(a.distance.row(y), b.distance.row(y)));
    EXPECT_TRUE(std::ranges::equal(a.low.row(y), b.low.row(y)));
  }
}

TEST(MotionCorrection, SaturatedSamplesStaySaturated) {
  Planes planes = wall(60);
  planes.planes[2][5 * kColumns + 7] = 4095;
  ConverterRig rig(sensor());
  const PmdMaps& maps = rig.converter().convert(planes.samples());
  EXPECT_TRUE(maps.moved);
  EXPECT_NE(maps.flags.at(7, 5) & kPmdSaturated, 0);
  EXPECT_EQ(maps.distance.at(7, 5), 0);
}

// A change that is no brightness any more: what it hides cannot be told.
TEST(MotionCorrection, LeavesOutWhatChangesTooMuch) {
  ConverterRig rig(sensor());
  const Planes planes = wall(500);
  const PmdMaps& maps = rig.converter().convert(planes.samples());
  EXPECT_NE(maps.flags.at(20, 20) & kPmdAsymmetric, 0);
  EXPECT_EQ(maps.distance.at(20, 20), 0);
}

TEST(MotionCorrection, OfSeveralExposuresNoneIsCorrected) {
  ConverterRig rig(sensor());
  const Planes planes = wall(60);
  const std::array<PmdExposure, 2> both{
      {{.samples = planes.samples()}, {.samples = planes.samples(), .integration = 128}}};
  const PmdMaps& maps = rig.converter().convert({.first = both});
  EXPECT_FALSE(maps.moved);
  EXPECT_NE(maps.flags.at(20, 20) & kPmdAsymmetric, 0);
}

}  // namespace
}  // namespace stof::dsp
