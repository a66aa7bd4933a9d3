#include "dsp/pmd/converter.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include <gtest/gtest.h>

#include "tests/dsp/pmd/converter_rig.h"
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

// One exposure of a sensor.
class Rig {
 public:
  explicit Rig(const PmdSensor& sensor)
      : rig_(sensor), planes_(sensor.lens.width, sensor.lens.height) {}

  std::vector<std::uint16_t>& plane(std::size_t k) { return planes_.planes[k]; }
  void show(std::size_t pixel, double distance_m, double light, double amplitude) {
    planes_.show(pixel, distance_m, light, amplitude);
  }
  const PmdMaps& convert() { return rig_.converter().convert(planes_.samples()); }

 private:
  ConverterRig rig_;
  Planes planes_;
};

TEST(PmdConverter, ReadsAPlaneAtTwoMetres) {
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
      ASSERT_EQ(maps.ratio.at(x, y), 102);  // 0.4
      ASSERT_EQ(maps.low.at(x, y), maps.distance.at(x, y) - 2 * maps.sigma.at(x, y));
      ASSERT_EQ(maps.high.at(x, y), maps.distance.at(x, y) + 2 * maps.sigma.at(x, y));
    }
  }
}

TEST(PmdConverter, SaysWhatItsReadingsMean) {
  Rig rig(sensor_of(3, 2));
  const PmdMaps& maps = rig.convert();
  EXPECT_EQ(maps.range, 29979U);
  EXPECT_EQ(maps.widest, 14989);
  EXPECT_EQ(maps.integration, kReferenceIntegration);
  EXPECT_TRUE(maps.long_distance.empty());
  EXPECT_EQ(maps.distance.stride(), 5);
  EXPECT_EQ(maps.sigma.stride(), 5);
}

// The columns outside of the picture are what the interval kernel reads there.
TEST(PmdConverter, KeepsThePaddingOfItsRowsEmpty) {
  Rig rig(sensor_of(9, 4));
  for (std::size_t i = 0; i < 36; ++i) {
    rig.show(i, 2.5, 1500, 600);
  }
  const PmdMaps& maps = rig.convert();
  for (int y = 0; y < 4; ++y) {
    for (const ImageView<QuarterMm>& image : {maps.distance, maps.sigma}) {
      EXPECT_EQ(image.row(y).data()[-1], 0);
      EXPECT_EQ(image.row(y).data()[9], 0);
    }
  }
}

TEST(PmdConverter, TakesMemoryForWhatTheSensorHas) {
  const auto bytes = [](const PmdSensor& sensor) {
    return bytes_taken([&](Arena& arena) { PmdConverter(sensor, arena); });
  };
  PmdSensor sensor = sensor_of(64, 16);
  const std::size_t plain = bytes(sensor);
  EXPECT_LE(plain, 21U * 64 * 16 + 4096);
  sensor.emitter_count = 2;
  EXPECT_EQ(bytes(sensor), plain + 10U * 64 * 16);
  const std::size_t with_lights = bytes(sensor);
  sensor.second = PmdFrequency{.modulation = {18'750'000}};
  EXPECT_GT(bytes(sensor), with_lights + 4U * 64 * 16);
  EXPECT_LT(bytes(sensor), with_lights + 5U * 64 * 16);
}

TEST(PmdConverter, WorksFromOnePixelUp) {
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

TEST(PmdConverter, SaysWhyBlackSaturatedAndFlatFramesHoldNothing) {
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

TEST(PmdConverter, CarriesNoDistanceWhereAMissingFlagIsSet) {
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

TEST(PmdConverter, GivesBothSidesOfTheWrapNoDistance) {
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
TEST(PmdConverter, CallsAStaticSceneEvenAndAMovingOneNot) {
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

}  // namespace
}  // namespace stof::dsp
