#include "host/calibrate/rig/extrinsics/long_exposure.h"

#include <cmath>
#include <numbers>

#include <gtest/gtest.h>

#include "host/evaluate/owning_converter.h"
#include "tests/host/calibrate/rig/gaussian.h"

namespace stof::host {
namespace {

using test::Gaussian;

constexpr int kSide = 64;
constexpr double kTurn = 2 * std::numbers::pi;
constexpr double kFarthestM = 7.4948;  // a turn at 20 MHz

dsp::PmdSensor led_camera() {
  dsp::PmdSensor sensor;
  sensor.lens = {.width = kSide, .height = kSide, .fx = 1e6, .fy = 1e6, .cx = 32, .cy = 32};
  sensor.dark_lsb = 20;
  sensor.saturation_lsb = 4095;
  sensor.noise_lsb = 12;
  sensor.frequency.wiggling = dsp::wiggling_of_harmonics(0.05, 0.0114);
  sensor.frequency.min_modulation_ratio = 0;
  return sensor;
}

// Frames of a wall across the line of sight.
dataset::PmdRecording wall_at(double distance_m, int frames, double noise_lsb) {
  Gaussian random(7);
  const double p = kTurn * distance_m / kFarthestM;
  constexpr double kAmplitude = 200;
  const double i = std::cos(p) + 0.05 * std::cos(3 * p) + 0.0114 * std::cos(5 * p);
  const double q = std::sin(p) - 0.05 * std::sin(3 * p) + 0.0114 * std::sin(5 * p);
  const std::array<double, 4> samples{600 + kAmplitude * i, 600 - kAmplitude * q,
                                      600 - kAmplitude * i, 600 + kAmplitude * q};
  dataset::PmdRecording recording;
  for (int n = 0; n < frames; ++n) {
    dataset::Image<std::uint16_t>& frame = recording.frames.emplace_back(kSide, 4 * kSide);
    for (std::size_t at = 0; at < frame.pixels.size(); ++at) {
      const double clean = samples[at / (kSide * kSide)];
      frame.pixels[at] = static_cast<std::uint16_t>(std::lround(clean + random.next(noise_lsb)));
    }
  }
  return recording;
}

double mean_error_mm(const dsp::PmdSensor& sensor, const dataset::PmdRecording& recording,
                     double distance_m) {
  OwningConverter converter(sensor);
  double sum = 0;
  for (std::size_t n = 0; n < recording.frames.size(); ++n) {
    const dsp::PmdMaps& maps = converter->convert(recording.samples(n));
    for (int y = 0; y < kSide; ++y) {
      for (int x = 0; x < kSide; ++x) {
        EXPECT_NE(maps.distance.at(x, y), dsp::kNoDepth);
        sum += maps.distance.at(x, y) / 4.0;
      }
    }
  }
  return sum / (kSide * kSide * static_cast<double>(recording.frames.size())) - 1000 * distance_m;
}

// 8 samples of 12 bits fit into one: of 16 frames two sums are left.
TEST(LongExposure, IsNotBentByNoiseAsAMeanOfDistancesIs) {
  const dsp::PmdSensor sensor = led_camera();
  constexpr double kWhereWigglingBendsMost = kFarthestM * 5 / 16;  // sin 4 phi = 1
  dataset::PmdRecording frames = wall_at(kWhereWigglingBendsMost, 16, 12);
  const double of_distances = mean_error_mm(sensor, frames, kWhereWigglingBendsMost);
  const LongExposures seen = lengthened(std::move(frames), sensor);
  ASSERT_EQ(seen.recording.frames.size(), 2U);
  const double of_sums = mean_error_mm(seen.sensor, seen.recording, kWhereWigglingBendsMost);
  std::printf("figure: mean of distances off by %.2f mm, of sums by %.2f mm\n", of_distances,
              of_sums);
  EXPECT_GT(std::abs(of_distances), 0.4);
  EXPECT_LT(std::abs(of_sums), 0.2);
}

TEST(LongExposure, KeepsWhatOneFrameDidNotSee) {
  dsp::PmdSensor sensor = led_camera();
  sensor.min_amplitude_lsb = 10;
  dataset::PmdRecording frames = wall_at(1, 5, 0);
  frames.frames[3].pixels[17] = 4095;
  frames.frames[4].pixels[18] = 0;
  const LongExposures seen = lengthened(std::move(frames), sensor);
  ASSERT_EQ(seen.recording.frames.size(), 1U);
  EXPECT_EQ(seen.sensor.dark_lsb, 100);
  EXPECT_EQ(seen.sensor.min_amplitude_lsb, 50);
  OwningConverter converter(seen.sensor);
  const dsp::PmdMaps& maps = converter->convert(seen.recording.samples(0));
  EXPECT_EQ(maps.distance.at(17, 0), dsp::kNoDepth);
  EXPECT_NE(maps.flags.at(17, 0) & dsp::kPmdSaturated, 0);
  EXPECT_EQ(maps.distance.at(18, 0), dsp::kNoDepth);
  EXPECT_NE(maps.flags.at(18, 0) & dsp::kPmdUnderRange, 0);
  EXPECT_NE(maps.distance.at(19, 0), dsp::kNoDepth);
}

TEST(LongExposure, IsASingleFrameOfACameraWhoseSamplesAreFull) {
  dsp::PmdSensor sensor = led_camera();
  sensor.saturation_lsb = 30000;
  const LongExposures seen = lengthened(wall_at(1, 3, 0), sensor);
  EXPECT_EQ(seen.recording.frames.size(), 3U);
  EXPECT_EQ(seen.sensor.dark_lsb, sensor.dark_lsb);
  EXPECT_TRUE(lengthened({}, sensor).recording.frames.empty());
}

}  // namespace
}  // namespace stof::host
