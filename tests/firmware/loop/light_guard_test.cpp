#include "firmware/loop/light_guard.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <numbers>
#include <random>
#include <vector>

#include <gtest/gtest.h>

namespace stof::firmware {
namespace {

constexpr int kWidth = 64;
constexpr int kHeight = 48;

dsp::PmdSensor sensor() {
  dsp::PmdSensor out;
  out.lens.width = kWidth;
  out.lens.height = kHeight;
  out.dark_lsb = 100;
  out.noise_lsb = 2.5;
  return out;
}

// Samples with light in the first `lit` of all pixels, and ambient light in all of them.
struct Light {
  int lit = 0;
  double ambient = 0;      // LSB
  double amplitude = 60;   // LSB, of light of the lamp
  double noise_scale = 1;  // of what the calibration says
  double stray_i = 0;      // LSB, in all pixels
  double flicker = 0;      // share that the ambient light changes by from sample to sample
};

// Standard normal numbers; each picture takes its own from some place on.
double noise_at(std::size_t place) {
  static const std::vector<double> numbers = [] {
    std::vector<double> made(1U << 17);
    std::mt19937 random(1);
    std::normal_distribution<double> normal;
    std::ranges::generate(made, [&] { return normal(random); });
    return made;
  }();
  return numbers[place % numbers.size()];
}

class Samples {
 public:
  Samples(const Light& light, std::uint32_t seed) {
    std::mt19937 random(seed);
    const double shot =
        std::sqrt(2.5 * 2.5 + (light.ambient + light.amplitude) / sensor().electrons_per_lsb);
    std::size_t place = random();
    const double deviation = shot * light.noise_scale;
    std::uniform_real_distribution<double> flicker(-light.flicker, light.flicker);
    for (int k = 0; k < 4; ++k) {
      std::vector<std::uint16_t>& plane = planes_[static_cast<std::size_t>(k)];
      const double ambient = light.ambient * (1 + flicker(random));
      const double stray = light.stray_i / 2 * std::cos(k * std::numbers::pi / 2);
      for (int i = 0; i < kWidth * kHeight; ++i) {
        const double back =
            i < light.lit ? light.amplitude * (1 + std::cos(0.3 + k * std::numbers::pi / 2)) : 0;
        plane.push_back(static_cast<std::uint16_t>(
            std::lround(200 + ambient + stray + back + deviation * noise_at(place++))));
      }
      frame.samples[static_cast<std::size_t>(k)] = {plane.data(), kWidth, kHeight};
    }
  }

  hal::PmdFrame frame;

 private:
  std::array<std::vector<std::uint16_t>, 4> planes_;
};

constexpr int kAll = kWidth * kHeight;

bool is_lit(LightGuard& guard, const Light& light, std::uint32_t seed = 1) {
  return guard.is_lit(Samples(light, seed).frame);
}

TEST(LightGuard, WhatIsDarkFromTheStartHasNoLight) {
  LightGuard guard(sensor());
  for (std::uint32_t seed = 0; seed < 100; ++seed) {
    EXPECT_FALSE(is_lit(guard, {}, seed)) << seed;
  }
  EXPECT_TRUE(is_lit(guard, {.lit = kAll / 4}));
}

TEST(LightGuard, LightThatIsGoneIsGoneUntilItIsBack) {
  LightGuard guard(sensor());
  EXPECT_TRUE(is_lit(guard, {.lit = kAll}));
  for (std::uint32_t seed = 0; seed < 100; ++seed) {
    EXPECT_FALSE(is_lit(guard, {}, seed)) << seed;
  }
  EXPECT_TRUE(is_lit(guard, {.lit = kAll / 4}));
}

TEST(LightGuard, LightThatFadesIsThereAsLongAsAFewPixelsHaveIt) {
  LightGuard guard(sensor());
  EXPECT_TRUE(is_lit(guard, {.lit = kAll}));
  EXPECT_TRUE(is_lit(guard, {.lit = kAll / 16})) << "the camera turns away";
  EXPECT_TRUE(is_lit(guard, {.lit = kAll / 192}));
  EXPECT_FALSE(is_lit(guard, {})) << "nothing within its reach: noise is no distance";
  EXPECT_FALSE(is_lit(guard, {.lit = kAll / 192})) << "it takes more to come back";
  EXPECT_TRUE(is_lit(guard, {.lit = kAll / 64}));
}

TEST(LightGuard, TheNoiseOfSunlightIsNoLight) {
  for (const double ambient : {0.0, 300.0, 1000.0, 2500.0}) {
    LightGuard guard(sensor());
    EXPECT_TRUE(is_lit(guard, {.lit = kAll, .ambient = ambient, .amplitude = 60 + ambient / 4}));
    for (std::uint32_t seed = 0; seed < 20; ++seed) {
      EXPECT_FALSE(is_lit(guard, {.ambient = ambient}, seed)) << ambient;
    }
  }
}

// No pixel has a reading then.
TEST(LightGuard, LightThatOtherLightDrownsIsNone) {
  LightGuard guard(sensor());
  EXPECT_TRUE(is_lit(guard, {.lit = kAll, .ambient = 100}));
  EXPECT_FALSE(is_lit(guard, {.lit = kAll, .ambient = 1000}));
  EXPECT_TRUE(is_lit(guard, {.lit = kAll, .ambient = 100}));
}

TEST(LightGuard, NoiseThatTheCalibrationDoesNotKnowIsNoLight) {
  for (const double scale : {0.0, 0.5, 1.5, 2.0, 3.0, 5.0, 8.0, 16.0}) {
    LightGuard guard(sensor());
    for (std::uint32_t seed = 0; seed < 20; ++seed) {
      EXPECT_FALSE(is_lit(guard, {.noise_scale = scale}, seed)) << scale;
    }
  }
}

TEST(LightGuard, AmbientLightThatFlickersIsNoLight) {
  LightGuard guard(sensor());
  for (const double ambient : {300.0, 1000.0}) {
    for (std::uint32_t seed = 0; seed < 100; ++seed) {
      EXPECT_FALSE(is_lit(guard, {.ambient = ambient, .flicker = 0.1}, seed)) << seed;
    }
  }
}

TEST(LightGuard, StrayLightIsNoLightThatComesBackAndItsAbsenceIsNone) {
  dsp::PmdSensor stray = sensor();
  stray.frequency.stray_i_lsb = 80;
  LightGuard guard(stray);
  EXPECT_FALSE(is_lit(guard, {.stray_i = 80})) << "the lamp shines, nothing is within its reach";
  EXPECT_FALSE(is_lit(guard, {})) << "less the stray light, dark samples have an amplitude";
  EXPECT_TRUE(is_lit(guard, {.lit = kAll / 4, .stray_i = 80}));
}

TEST(LightGuard, AnyCalibrationCanBeComputedWith) {
  for (const double value : {0.0, 1e-300, 1e300}) {
    dsp::PmdSensor wild = sensor();
    wild.noise_lsb = value;
    wild.suppressed_lsb = value;
    wild.frequency.stray_i_lsb = value;
    wild.electrons_per_lsb = value == 0 ? 1e-300 : value;
    LightGuard guard(wild);
    static_cast<void>(is_lit(guard, {.lit = kAll}));
    static_cast<void>(is_lit(guard, {}));
  }
}

}  // namespace
}  // namespace stof::firmware
