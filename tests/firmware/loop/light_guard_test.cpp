#include "firmware/loop/light_guard.h"

#include <array>
#include <cmath>
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
class Samples {
 public:
  Samples(int lit, double amplitude, double ambient, std::uint32_t seed) {
    std::mt19937 random(seed);
    const double shot = std::sqrt(2.5 * 2.5 + (ambient + amplitude) / sensor().electrons_per_lsb);
    std::normal_distribution<double> noise(0, shot);
    for (int k = 0; k < 4; ++k) {
      std::vector<std::uint16_t>& plane = planes_[static_cast<std::size_t>(k)];
      for (int i = 0; i < kWidth * kHeight; ++i) {
        const double light =
            i < lit ? amplitude * std::cos(0.3 + k * std::numbers::pi / 2) + amplitude : 0;
        plane.push_back(
            static_cast<std::uint16_t>(std::lround(100 + ambient + light + noise(random))));
      }
      frame.samples[static_cast<std::size_t>(k)] = {plane.data(), kWidth, kHeight};
    }
  }

  hal::PmdFrame frame;

 private:
  std::array<std::vector<std::uint16_t>, 4> planes_;
};

constexpr int kAll = kWidth * kHeight;

bool gone(LightGuard& guard, int lit, double ambient = 0, std::uint32_t seed = 1) {
  return guard.gone(Samples(lit, 60, ambient, seed).frame);
}

TEST(LightGuard, LightThatIsGoneAtOnceIsGoneUntilItIsBack) {
  LightGuard guard(sensor());
  EXPECT_FALSE(gone(guard, kAll));
  for (std::uint32_t seed = 0; seed < 100; ++seed) {
    EXPECT_TRUE(gone(guard, 0, 0, seed)) << seed;
  }
  EXPECT_FALSE(gone(guard, kAll / 4));
}

TEST(LightGuard, TheNoiseOfSunlightIsNoLight) {
  for (const double ambient : {0.0, 300.0, 1000.0, 2500.0}) {
    LightGuard guard(sensor());
    EXPECT_FALSE(gone(guard, kAll, ambient));
    for (std::uint32_t seed = 0; seed < 20; ++seed) {
      EXPECT_TRUE(gone(guard, 0, ambient, seed)) << ambient;
    }
  }
}

TEST(LightGuard, LightThatFadesOrNeverWasIsNoFailure) {
  LightGuard guard(sensor());
  EXPECT_FALSE(gone(guard, 0)) << "nothing was ever lit";
  EXPECT_FALSE(gone(guard, kAll));
  EXPECT_FALSE(gone(guard, kAll / 2));
  EXPECT_FALSE(gone(guard, kAll / 16)) << "the camera turns away";
  EXPECT_FALSE(gone(guard, 0)) << "and sees nothing within its reach";
  EXPECT_FALSE(gone(guard, kAll / 100));
}

TEST(LightGuard, AnyCalibrationCanBeComputedWith) {
  for (const double value : {0.0, 1e-300, 1e300}) {
    dsp::PmdSensor wild = sensor();
    wild.noise_lsb = value;
    wild.suppressed_lsb = value;
    wild.electrons_per_lsb = value == 0 ? 1e-300 : value;
    LightGuard guard(wild);
    static_cast<void>(gone(guard, kAll));
    static_cast<void>(gone(guard, 0));
  }
}

}  // namespace
}  // namespace stof::firmware
