#include "dsp/pmd/converter.h"

#include <algorithm>
#include <cmath>
#include <memory>
#include <numbers>
#include <vector>

#include <gtest/gtest.h>

#include "dsp/calib/pmd_tables.h"
#include "tests/support/random.h"

namespace stof::dsp {
namespace {

PmdSensor sensor_of(int width, int height) {
  PmdSensor sensor;
  sensor.lens = {.width = width, .height = height, .fx = 45.28, .fy = 45.28, .cx = 32, .cy = 8};
  sensor.dark_lsb = 100;
  sensor.electrons_per_lsb = 61;
  sensor.noise_lsb = 5;
  return sensor;
}

// Exactly as much memory as was asked for.
class Rig {
 public:
  explicit Rig(const PmdSensor& sensor)
      : bytes_(Converter::bytes_needed(sensor.lens.width, sensor.lens.height)),
        memory_(new(std::align_val_t{Arena::kAlign}) std::byte[bytes_]),
        arena_({memory_, bytes_}),
        converter_(sensor, arena_),
        width_(sensor.lens.width),
        height_(sensor.lens.height) {
    for (std::vector<std::uint16_t>& plane : planes_) {
      plane.resize(static_cast<std::size_t>(width_) * static_cast<std::size_t>(height_));
    }
  }
  Rig(const Rig&) = delete;
  Rig& operator=(const Rig&) = delete;
  ~Rig() { ::operator delete[](memory_, std::align_val_t{Arena::kAlign}); }

  std::vector<std::uint16_t>& plane(std::size_t k) { return planes_[k]; }
  // A surface at distance_m; light and amplitude in LSB.
  void show(std::size_t pixel, double distance_m, double light, double amplitude) {
    const double phi = distance_m / 7.49481145 * 2 * std::numbers::pi;
    for (std::size_t k = 0; k < 4; ++k) {
      const double turn = phi + static_cast<double>(k) * std::numbers::pi / 2;
      planes_[k][pixel] =
          static_cast<std::uint16_t>(std::lround(100 + light + amplitude * std::cos(turn)));
    }
  }
  const PmdMaps& convert() {
    const auto view = [this](std::size_t k) {
      return ImageView<const std::uint16_t>(planes_[k].data(), width_, height_);
    };
    return converter_.convert({view(0), view(1), view(2), view(3)});
  }

 private:
  std::size_t bytes_;
  std::byte* memory_;
  Arena arena_;
  Converter converter_;
  int width_;
  int height_;
  std::array<std::vector<std::uint16_t>, 4> planes_;
};

TEST(Converter, ReadsAPlaneAtTwoMetres) {
  Rig rig(sensor_of(64, 16));
  for (std::size_t i = 0; i < 64 * 16; ++i) {
    rig.show(i, 2.0, 1500, 600);
  }
  const PmdMaps& maps = rig.convert();
  for (int y = 0; y < 16; ++y) {
    for (int x = 0; x < 64; ++x) {
      ASSERT_NEAR(maps.distance.at(x, y), 8000, 4);  // samples are whole numbers: 1 mm
      ASSERT_EQ(maps.flags.at(x, y), 0);
      ASSERT_NEAR(maps.amp2.at(x, y), 1200, 2);
      ASSERT_EQ(maps.offset.at(x, y), 1500);
      ASSERT_EQ(maps.low.at(x, y), maps.distance.at(x, y) - 2 * maps.sigma.at(x, y));
      ASSERT_EQ(maps.high.at(x, y), maps.distance.at(x, y) + 2 * maps.sigma.at(x, y));
    }
  }
}

TEST(Converter, WorksFromOnePixelUp) {
  for (const auto& [w, h] : {std::pair{1, 1}, {1, 9}, {2, 1}, {7, 3}, {8, 2}, {17, 5}}) {
    Rig rig(sensor_of(w, h));
    const std::size_t count = static_cast<std::size_t>(w) * static_cast<std::size_t>(h);
    for (std::size_t i = 0; i < count; ++i) {
      rig.show(i, 3.0, 1500, 600);
    }
    const PmdMaps& maps = rig.convert();
    EXPECT_NEAR(maps.distance.at(w - 1, h - 1), 12000, 4) << w << "x" << h;
    EXPECT_GT(maps.high.at(w - 1, h - 1), maps.low.at(w - 1, h - 1)) << w << "x" << h;
  }
}

TEST(Converter, SaysWhyBlackSaturatedAndFlatFramesHoldNothing) {
  for (const auto& [value, reason] : {std::pair{0, kPmdUnderRange},
                                      {4095, kPmdSaturated},
                                      {65535, kPmdSaturated},
                                      {1000, kPmdLowAmplitude}}) {
    Rig rig(sensor_of(17, 3));
    for (std::size_t k = 0; k < 4; ++k) {
      std::ranges::fill(rig.plane(k), static_cast<std::uint16_t>(value));
    }
    const PmdMaps& maps = rig.convert();
    for (int y = 0; y < 3; ++y) {
      for (int x = 0; x < 17; ++x) {
        ASSERT_TRUE(maps.flags.at(x, y) & reason) << value;
        ASSERT_EQ(
            maps.distance.at(x, y) + maps.sigma.at(x, y) + maps.low.at(x, y) + maps.high.at(x, y),
            0)
            << value;
      }
    }
  }
}

TEST(Converter, CarriesNoDistanceWhereAMissingFlagIsSet) {
  Rig rig(sensor_of(33, 9));
  test::Random random(5);
  for (std::size_t k = 0; k < 4; ++k) {
    random.fill(std::span(rig.plane(k)), 0, 4095);
  }
  const PmdMaps& maps = rig.convert();
  int some = 0;
  for (int y = 0; y < 9; ++y) {
    for (int x = 0; x < 33; ++x) {
      const bool missing = (maps.flags.at(x, y) & kPmdMissing) != 0;
      ASSERT_EQ(missing, maps.distance.at(x, y) == kNoDepth);
      ASSERT_EQ(missing, maps.sigma.at(x, y) == 0);
      ASSERT_EQ(missing, maps.high.at(x, y) == kNoDepth);
      ASSERT_LE(maps.low.at(x, y), maps.distance.at(x, y));
      ASSERT_GE(maps.high.at(x, y), maps.distance.at(x, y));
      some += missing ? 1 : 0;
    }
  }
  EXPECT_GT(some, 0);
}

TEST(Converter, GivesBothSidesOfTheWrapNoDistance) {
  Rig rig(sensor_of(8, 1));
  for (std::size_t i = 0; i < 8; ++i) {
    rig.show(i, i < 4 ? 0.3 : 7.4, 1500, 600);
  }
  const PmdMaps& maps = rig.convert();
  EXPECT_TRUE(maps.flags.at(3, 0) & maps.flags.at(4, 0) & kPmdWrapped);
  EXPECT_EQ(maps.distance.at(3, 0), kNoDepth);
  EXPECT_EQ(maps.distance.at(4, 0), kNoDepth);
  EXPECT_NEAR(maps.distance.at(2, 0), 1200, 4);
  EXPECT_NEAR(maps.distance.at(5, 0), 29600, 4);
}

// Odd harmonics (wiggling) cancel in A0 + A2 - A1 - A3; noise of the model stays under 6 sigma.
TEST(Converter, CallsAStaticSceneEvenAndAMovingOneNot) {
  Rig rig(sensor_of(64, 16));
  test::Random random(11);
  for (std::size_t i = 0; i < 64 * 16; ++i) {
    rig.show(i, 1.0 + static_cast<double>(i % 50) / 10, 1500, 600);
    for (std::size_t k = 0; k < 4; ++k) {  // about Gaussian, variance 1500 / 61 + 25 = 50
      int noise = 0;
      for (int part = 0; part < 6; ++part) {
        noise += random.between(-4, 4);  // variance 6.67 each, 40 in all
      }
      rig.plane(k)[i] = static_cast<std::uint16_t>(rig.plane(k)[i] + noise);
    }
  }
  rig.plane(0)[700] = static_cast<std::uint16_t>(rig.plane(0)[700] + 300);
  const PmdMaps& maps = rig.convert();
  int asymmetric = 0;
  for (int y = 0; y < 16; ++y) {
    for (int x = 0; x < 64; ++x) {
      asymmetric += (maps.flags.at(x, y) & kPmdAsymmetric) != 0 ? 1 : 0;
    }
  }
  EXPECT_EQ(asymmetric, 1);
  EXPECT_TRUE(maps.flags.at(700 % 64, 700 / 64) & kPmdAsymmetric);
}

TEST(PmdTables, SaturateLimitsThatLieOutsideSamples) {
  PmdSensor sensor;
  sensor.saturation_lsb = 1 << 20;
  sensor.under_lsb = -1;
  sensor.electrons_per_lsb = 1e-3;
  const PhaseLimits limits = phase_limits(sensor);
  EXPECT_EQ(limits.saturation, 65535);
  EXPECT_EQ(limits.lowest, 0);  // never
  EXPECT_EQ(limits.asymmetry_slope_q8, kMaxAsymmetrySlopeQ8);
  EXPECT_EQ(phase_limits({}).ratio_q16, 39322U);  // the chapter's 30 percent
}

}  // namespace
}  // namespace stof::dsp
