#include "dsp/pmd/range/emitter_offset.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include <gtest/gtest.h>

#include "dsp/calib/pmd/emitter_offset_table.h"
#include "dsp/calib/pmd/ray_table.h"
#include "dsp/pmd/range/phase_to_distance.h"
#include "tests/support/kernel_check.h"

namespace stof::dsp {
namespace {

constexpr double kQuartersPerMetre = 4000;

PmdSensor sensor_with(std::vector<Emitter> lights) {
  PmdSensor sensor;
  sensor.lens = {
      .width = 64, .height = 16, .fx = 45.279, .fy = 45.279, .cx = 32.8, .cy = 10.0, .k1 = -0.1};
  sensor.emitter_count = static_cast<int>(lights.size());
  std::ranges::copy(lights, sensor.emitters.begin());
  return sensor;
}

// The tables of a sensor.
struct Tables {
  Tables(const PmdSensor& sensor, double units)
      : half(size(sensor)), area(size(sensor)), pole(size(sensor)) {
    fill_emitter_offset_table(sensor, units, {half, area, pole});
    shortest = shortest_way(sensor, units);
  }
  static std::size_t size(const PmdSensor& sensor) {
    return static_cast<std::size_t>(sensor.lens.width) *
           static_cast<std::size_t>(sensor.lens.height);
  }
  std::uint32_t correct(std::size_t pixel, std::uint32_t measured) const {
    best::emitter_offset({std::span(half).subspan(pixel, 1), std::span(area).subspan(pixel, 1),
                          std::span(pole).subspan(pixel, 1)},
                         shortest, {&measured, 1});
    return measured;
  }
  std::vector<std::int16_t> half;
  std::vector<std::int32_t> area;
  std::vector<std::int32_t> pole;
  std::uint32_t shortest = 0;
};

// Half of the way that light takes to a point d metres along the ray and back: of each light by how
// much of it comes back from a surface that faces the camera, its lobe falling with cos^power.
double measured_m(const PmdSensor& sensor, const std::array<double, 3>& ray, double d,
                  double power) {
  double weights = 0;
  double sum = 0;
  for (int j = 0; j < sensor.emitter_count; ++j) {
    const Emitter& e = sensor.emitters[static_cast<std::size_t>(j)];
    const double x = d * ray[0] - e[0];
    const double y = d * ray[1] - e[1];
    const double z = d * ray[2] - e[2];
    const double out = std::sqrt(x * x + y * y + z * z);
    const double weight = std::pow(z / out, power + 1) / (out * out);
    weights += weight;
    sum += weight * out;
  }
  return (d + sum / weights) / 2;
}

// Largest error in mm over the picture at d metres.
double worst_mm(const PmdSensor& sensor, double d, double power, double units) {
  const Tables tables(sensor, units);
  double worst = 0;
  for (int v = 0; v < sensor.lens.height; ++v) {
    for (int u = 0; u < sensor.lens.width; ++u) {
      const std::array<double, 3> ray = unit_ray(sensor.lens, u, v);
      const double way = measured_m(sensor, ray, d, power);
      const std::uint32_t found = tables.correct(static_cast<std::size_t>(v * 64 + u),
                                                 static_cast<std::uint32_t>(way * units + 0.5));
      worst = std::max(worst, std::abs(found / units - d) * 1000);
    }
  }
  return worst;
}

// d = ((ct)^2 - |e|^2) / (2 (ct - e . r)): 0.125 mm each of the reading's and the result's
// rounding, and of the table's.
TEST(EmitterOffset, OfOneLightAreExactAtEveryDistance) {
  for (const Emitter& light :
       {Emitter{0.12, 0, 0}, Emitter{-0.12, 0, 0}, Emitter{0.05, -0.2, 0.04}, Emitter{0, 0, 0}}) {
    const PmdSensor sensor = sensor_with({light});
    for (const double d : {0.3, 0.5, 1.0, 3.0, 7.0, 16.0}) {
      EXPECT_LE(worst_mm(sensor, d, 3, kQuartersPerMetre), 0.4) << light[0] << " at " << d;
      EXPECT_LE(worst_mm(sensor, d, 3, 10000), 0.2) << light[0] << " at " << d;
    }
  }
}

// Two lights 12 cm to either side leave 21 mm at 0.5 m and 14 mm at 1 m without correction.
TEST(EmitterOffset, OfTwoLightsLeaveOneMillimetreFromHalfAMetreOn) {
  for (const std::vector<Emitter>& lights :
       {std::vector<Emitter>{{-0.12, 0, 0}, {0.12, 0, 0}},
        std::vector<Emitter>{{0, -0.12, 0}, {0.12, 0, 0}},
        std::vector<Emitter>{{-0.12, 0, 0}, {0.12, 0, 0}, {0, 0.12, 0}, {0, -0.12, 0}}}) {
    const PmdSensor sensor = sensor_with(lights);
    for (const double d : {0.5, 0.6, 0.75, 1.0, 1.5, 2.0, 3.0, 6.0}) {
      EXPECT_LE(worst_mm(sensor, d, 3, kQuartersPerMetre), 1.3) << lights.size() << " at " << d;
    }
    EXPECT_LE(worst_mm(sensor, 0.3, 3, kQuartersPerMetre), 6) << lights.size();
  }
}

// Lobes are not all alike: Lambert's, and one that falls to half at 30 degrees.
TEST(EmitterOffset, OfTwoLightsOfAnotherLobeGainMostOfTheWay) {
  const PmdSensor sensor = sensor_with({{-0.12, 0, 0}, {0.12, 0, 0}});
  PmdSensor none = sensor;
  none.emitters = {};  // both at the lens
  for (const double d : {0.5, 1.0, 2.0}) {
    const std::array<double, 3> ray = unit_ray(sensor.lens, 63, 8);
    for (const double power : {2.0, 4.8}) {
      const double before = std::abs(measured_m(sensor, ray, d, power) - d) * 1000;
      EXPECT_LE(worst_mm(sensor, d, power, kQuartersPerMetre), 0.4 * before + 0.5)
          << power << " at " << d;
    }
  }
}

TEST(EmitterOffset, KeepTheirCorrectionBelowTheShortestWay) {
  const PmdSensor sensor = sensor_with({{-0.12, 0, 0}, {0.12, 0, 0}});
  const Tables tables(sensor, kQuartersPerMetre);
  EXPECT_EQ(tables.shortest, 2400U);
  const int there = static_cast<int>(tables.correct(0, 1200)) - 1200;
  EXPECT_EQ(static_cast<int>(tables.correct(0, 800)) - 800, there);
  EXPECT_EQ(static_cast<int>(tables.correct(0, 100)) - 100, there);
}

TEST(EmitterOffset, NeverEndAtNothing) {
  const Tables tables(sensor_with({{-0.3, 0, 0}}), kQuartersPerMetre);
  for (std::size_t pixel = 0; pixel < tables.half.size(); ++pixel) {
    for (const std::uint32_t d : {0U, 1U, 2U, 100U, 0xFFFFFFFFU}) {
      EXPECT_GE(tables.correct(pixel, d), 1U);
    }
  }
}

TEST(EmitterOffsetTable, IsZeroWhereAPixelHasNoRay) {
  PmdSensor sensor = sensor_with({{0.12, 0, 0}});
  sensor.lens.k1 = -1;  // folds over long before the border
  const Tables tables(sensor, kQuartersPerMetre);
  EXPECT_EQ(tables.half[0], 0);
  EXPECT_EQ(tables.area[0], 0);
  EXPECT_EQ(tables.correct(0, 4000), 4000U);
  EXPECT_NE(tables.area[10 * 64 + 33], 0);
}

TEST(EmitterOffset, EqualReferenceForEveryLengthAndExtreme) {
  for (int variant = 0; variant < 5; ++variant) {
    test::check_kernel([&](test::KernelCase& c) {
      const std::size_t n = c.length();
      const EmitterOffsetRow table{
          c.array<std::int16_t>(n, -32768, 32767),
          c.array<std::int32_t>(n, variant == 0 ? -2147483647 : -30000000, 30000000),
          c.array<std::int32_t>(n, 1 - (1 << 20), (1 << 20) - 1)};
      const auto distance = c.array<std::uint32_t>(n);
      for (std::uint32_t& d : distance) {
        d >>= static_cast<unsigned>(variant * 5);
      }
      c.run([&] { best::emitter_offset(table, variant == 1 ? 2 * kMostUnits : 1200, distance); });
    });
  }
}

}  // namespace
}  // namespace stof::dsp
