#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <numbers>
#include <optional>
#include <vector>

#include <gtest/gtest.h>

#include "dataset/dataset.h"
#include "tests/dsp/pmd/converter_rig.h"
#include "tests/support/recorded_scenes.h"

// Recorded frames with truth: the folder named by STOF_DATA.
namespace stof::dsp {
namespace {

std::filesystem::path recordings() { return test::recorded_scenes() / "tof" / "sim"; }

using RecordedPmd = test::RecordedScenes;

// One camera was simulated for all of them.
dataset::PmdRecording read(const std::filesystem::path& name) {
  dataset::Loaded<dataset::PmdRecording> recording =
      dataset::read_pmd(recordings() / name, recordings() / "wall" / "64x16_fppn.pgm");
  if (!recording) {
    ADD_FAILURE() << recording.error().message;
    return {};
  }
  return std::move(*recording);
}

std::vector<double> truth_mm(const std::filesystem::path& name, double per_mm) {
  std::filesystem::path file = recordings() / name;
  file += "_r_med.pgm";
  const dataset::Loaded<dataset::Image<std::uint16_t>> image = dataset::read_pgm16(file);
  std::vector<double> out;
  if (!image) {
    ADD_FAILURE() << image.error().message;
    return out;
  }
  for (const std::uint16_t value : image->pixels) {
    out.push_back(value / per_mm);
  }
  return out;
}

// Errors of a recording's frames, mm. Few frames of little light leave noise in a pixel's mean, so
// that of blocks of 8 x 8 pixels stands beside it: noise is an eighth there, what a model gets
// wrong is not.
struct Score {
  double pixels_mm = 0;  // mean over pixels of |mean error over frames|
  double blocks_mm = 0;  // mean over blocks of |mean error over frames and pixels|
  int pixels = 0;        // that have a distance in at least half of the frames
};

struct Sum {
  double mm = 0;
  std::size_t count = 0;
  double mean() const { return count == 0 ? 0 : mm / static_cast<double>(count); }
};

// By a sensor that may differ from the recording's.
Score score(const dataset::PmdRecording& recording, const PmdSensor& sensor,
            const std::vector<double>& truth) {
  constexpr std::size_t kBlock = 8;
  ConverterRig rig(sensor);
  const std::size_t w = static_cast<std::size_t>(sensor.lens.width);
  std::vector<Sum> pixels(truth.size());
  std::vector<Sum> blocks(truth.size() / (kBlock * kBlock));
  for (std::size_t n = 0; n < recording.frames.size(); ++n) {
    const PmdMaps& maps = rig.converter().convert(recording.samples(n));
    for (std::size_t i = 0; i < truth.size(); ++i) {
      const QuarterMm d = maps.distance.row(static_cast<int>(i / w))[i % w];
      if (d != kNoDepth) {
        const std::size_t block = i / w / kBlock * (w / kBlock) + i % w / kBlock;
        for (Sum* sum : {&pixels[i], &blocks[block]}) {
          sum->mm += d / 4.0 - truth[i];
          ++sum->count;
        }
      }
    }
  }
  Score out;
  for (const Sum& pixel : pixels) {
    if (2 * pixel.count >= recording.frames.size()) {
      out.pixels_mm += std::abs(pixel.mean());
      ++out.pixels;
    }
  }
  out.pixels_mm /= std::max(out.pixels, 1);
  for (const Sum& block : blocks) {
    out.blocks_mm += std::abs(block.mean()) / static_cast<double>(blocks.size());
  }
  return out;
}

struct Comparison {
  Score without;  // lights taken to be at the lens
  Score with;
};

Comparison compare(const std::filesystem::path& name, int lights) {
  const dataset::PmdRecording recording = read(name);
  const std::vector<double> truth = truth_mm(name, 8);
  PmdSensor sensor = recording.calibration.pmd;
  if (truth.size() != 1024 || sensor.emitter_count != lights) {
    ADD_FAILURE() << name << " is not a recording of 64 x 16 pixels and " << lights << " light(s)";
    return {};
  }
  Comparison out;
  out.with = score(recording, sensor, truth);
  sensor.emitter_count = 0;
  out.without = score(recording, sensor, truth);
  std::printf("%s: pixels %.2f mm, blocks %.2f mm; without the lights' places %.2f, %.2f mm\n",
              name.c_str(), out.with.pixels_mm, out.with.blocks_mm, out.without.pixels_mm,
              out.without.blocks_mm);
  return out;
}

// One light 12 cm beside the lens, 6 x 10 cm large, before a white board: up to 37 mm at the edges
// of the picture without the near model.
TEST_F(RecordedPmd, OneLightBesideTheLensLeavesFiveMillimetres) {
  for (const char* name : {"z0500", "z0750", "z1000", "z1500", "z2000", "z3000"}) {
    const Comparison found = compare(std::filesystem::path("emitter") / name, 1);
    EXPECT_GE(found.with.pixels, 1000) << name;
    EXPECT_LE(found.with.blocks_mm, 5) << name;
    EXPECT_GE(found.without.blocks_mm, 15) << name;
  }
  // The only one with enough light for single pixels.
  EXPECT_LE(compare("emitter/z0500", 1).with.pixels_mm, 5);
}

// Two lights 12 cm to either side; wiggling alone leaves up to 3.5 mm.
TEST_F(RecordedPmd, TwoLightsBesideTheLensLeaveFiveMillimetres) {
  for (const char* name : {"z0500", "z0750", "z1000", "z1500", "z2000", "z3000"}) {
    const Comparison found = compare(std::filesystem::path("wall") / name, 2);
    EXPECT_GE(found.with.pixels, 1000) << name;
    EXPECT_LE(found.with.blocks_mm, 5) << name;
  }
  const Comparison near = compare("wall/z0500", 2);
  EXPECT_LE(near.with.pixels_mm, 3);
  EXPECT_LE(near.with.pixels_mm, near.without.pixels_mm / 2);
}

// 4000 electrons of stray light at an apparent 1.5 m turn 1 to 6 m
// into 1.03, 1.92, 2.58, 3.01, 2.37 and 0.83 m. A sensor that knows them (both samples of a pair of
// them: I and Q) reads the wall.
TEST_F(RecordedPmd, StrayLightThatIsKnownBendsNoWall) {
  const double phase = 1.5 / 7.49481145 * 2 * std::numbers::pi;
  for (const char* name : {"z1000", "z2000", "z3000", "z4000", "z5000"}) {
    const std::filesystem::path prefix = std::filesystem::path("stray") / name;
    const dataset::PmdRecording recording = read(prefix);
    const std::vector<double> truth = truth_mm(prefix, 8);
    ASSERT_EQ(truth.size(), 1024U);
    PmdSensor sensor = recording.calibration.pmd;
    sensor.frequency.min_modulation_ratio =
        0.1;  // stray light counts as light that is not modulated
    const Score without = score(recording, sensor, truth);
    sensor.frequency.stray_i_lsb = 2 * 4000 / sensor.electrons_per_lsb * std::cos(phase);
    sensor.frequency.stray_q_lsb = 2 * 4000 / sensor.electrons_per_lsb * std::sin(phase);
    const Score with = score(recording, sensor, truth);
    std::printf("%s: %.1f mm with stray light, %.1f mm without\n", prefix.c_str(),
                without.blocks_mm, with.blocks_mm);
    // Four frames; the noise of a block's mean at 5 m is 6 mm.
    EXPECT_LE(with.blocks_mm, 25) << name;
    EXPECT_LE(with.blocks_mm, without.blocks_mm / 5) << name;
  }
}

// A wall from 6 to 34 m: nothing that is given is off by a turn of the first frequency.
TEST_F(RecordedPmd, TwoFrequenciesReachBeyondOneTurn) {
  const std::filesystem::path dual = recordings() / "dual";
  const dataset::Loaded<dataset::PmdRecording> recording = dataset::read_pmd_pair(
      dual / "20_18.75_f0", dual / "20_18.75_f1", recordings() / "wall" / "64x16_fppn.pgm");
  ASSERT_TRUE(recording) << recording.error().message;
  const std::vector<double> truth = truth_mm("dual/20_18.75_f0", 1);
  ASSERT_EQ(truth.size(), 1024U);
  PmdSensor sensor = recording->calibration.pmd;
  sensor.frequency.min_modulation_ratio = 0.25;  // serves sensors of two frequencies
  sensor.second->min_modulation_ratio = 0.25;
  ConverterRig rig(sensor);
  std::vector<double> errors;
  int wrong = 0;
  int beyond = 0;
  for (std::size_t n = 0; n < recording->frames.size(); ++n) {
    const PmdExposure first{.samples = recording->samples(n)};
    const PmdExposure second{.samples = recording->second_samples(n)};
    const PmdMaps& maps = rig.converter().convert({.first = {&first, 1}, .second = {&second, 1}});
    for (std::size_t i = 0; i < truth.size(); ++i) {
      const std::uint32_t d = maps.long_distance.row(static_cast<int>(i / 64))[i % 64];
      if (d != 0) {
        errors.push_back(std::abs(d / 10.0 - truth[i]));
        wrong += errors.back() > 3747 ? 1 : 0;
        beyond += truth[i] > 7494 ? 1 : 0;
      }
    }
  }
  ASSERT_FALSE(errors.empty());
  std::ranges::nth_element(errors, errors.begin() + static_cast<std::ptrdiff_t>(errors.size() / 2));
  std::printf("%zu readings, %d of them beyond one turn, %d a turn off, median error %.1f mm\n",
              errors.size(), beyond, wrong, errors[errors.size() / 2]);
  EXPECT_GE(beyond, 500);
  EXPECT_EQ(wrong, 0);
  EXPECT_LE(errors[errors.size() / 2], 50);
}

}  // namespace
}  // namespace stof::dsp
