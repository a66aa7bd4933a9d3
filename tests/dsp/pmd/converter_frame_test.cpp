#include <array>
#include <cmath>
#include <vector>

#include <gtest/gtest.h>

#include "dsp/pmd/interval/fill_intervals.h"
#include "tests/dsp/pmd/converter_rig.h"
#include "tests/support/random.h"

// What a frame brings beside one exposure of one frequency, and what a sensor may have beside that.
namespace stof::dsp {
namespace {

constexpr double kTurnM = 7.49481145;

PmdSensor frame_sensor(int width, int height) {
  PmdSensor sensor;
  sensor.lens = {.width = width, .height = height, .fx = 45.28, .fy = 45.28, .cx = 32, .cy = 8};
  sensor.dark_lsb = 100;
  sensor.electrons_per_lsb = 61;
  sensor.noise_lsb = 5;
  return sensor;
}

PmdFrame frame_of(const PmdExposure& first) { return {.first = {&first, 1}}; }

TEST(ConverterFrame, SubtractsStrayLightByIntegrationTime) {
  PmdSensor sensor = frame_sensor(16, 1);
  sensor.frequency.stray_i_lsb = 40;  // 4000 electrons at an apparent 1.5 m
  sensor.frequency.stray_q_lsb = 124;
  ConverterRig rig(sensor);
  for (const double times : {0.5, 1.0, 2.0}) {
    Planes planes(16, 1);
    for (std::size_t i = 0; i < 16; ++i) {
      planes.show(i, 3.0, 700 * times, 250 * times);
      const std::array<double, 4> stray{20, -62, -20, 62};
      for (std::size_t k = 0; k < 4; ++k) {
        planes.planes[k][i] =
            static_cast<std::uint16_t>(planes.planes[k][i] + std::lround(stray[k] * times));
      }
    }
    const PmdMaps& maps = rig.converter().convert(frame_of(
        {.samples = planes.samples(), .integration = static_cast<IntegrationQ8>(256 * times)}));
    EXPECT_NEAR(maps.distance.at(7, 0), 12000, 20 / times) << times;  // of whole samples
    EXPECT_NEAR(maps.amp2.at(7, 0), 500 * times, 2) << times;
    EXPECT_EQ(maps.integration, 256 * times);
  }
}

TEST(ConverterFrame, MovesWithTheTemperature) {
  PmdSensor sensor = frame_sensor(8, 1);
  sensor.frequency.offset_m_per_k = 0.015;
  sensor.reference_c = 20;
  ConverterRig rig(sensor);
  Planes planes(8, 1);
  planes.show_everywhere(2.0, 1500, 600);
  const PmdExposure exposure{.samples = planes.samples()};
  const int here = rig.converter().convert(frame_of(exposure)).distance.at(3, 0);
  EXPECT_NEAR(here, 8000, 4);
  PmdFrame frame = frame_of(exposure);
  frame.temperature_q8 = 30 * 256;
  EXPECT_NEAR(rig.converter().convert(frame).distance.at(3, 0), here - 600, 1);
  frame.temperature_q8 = 20 * 256;
  EXPECT_EQ(rig.converter().convert(frame).distance.at(3, 0), here);
  frame.temperature_q8 = (20 - 200) * 256;  // 3 m further: nothing is kept from frame to frame
  EXPECT_NEAR(rig.converter().convert(frame).distance.at(3, 0), here + 12000, 2);
  EXPECT_EQ(rig.converter().convert(planes.samples()).distance.at(3, 0), here);
}

TEST(ConverterFrame, AppliesTheStraightLine) {
  PmdSensor sensor = frame_sensor(8, 1);
  sensor.scale = 1.02;
  sensor.shift_m = -0.25;
  ConverterRig rig(sensor);
  Planes planes(8, 1);
  planes.show_everywhere(2.0, 1500, 600);
  const PmdMaps& maps = rig.converter().convert(planes.samples());
  EXPECT_NEAR(maps.distance.at(3, 0), (2.0 * 1.02 - 0.25) * 4000, 5);
  EXPECT_EQ(maps.range, static_cast<std::uint32_t>(std::lround(kTurnM * 1.02 * 4000)));
  // 0.1 m would lie 15 cm behind the lens: it is one range further.
  planes.show_everywhere(0.1, 1500, 600);
  rig.converter().convert(planes.samples());
  EXPECT_NEAR(maps.distance.at(3, 0), ((0.1 + kTurnM) * 1.02 - 0.25) * 4000, 5);
}

TEST(ConverterFrame, TakesSigmaFromThePolynomialWhereThereIsOne) {
  PmdSensor sensor = frame_sensor(8, 1);
  sensor.sigma_polynomial = SigmaPolynomial{.a = 0.1, .b = 0.002, .c = 3e-5};
  ConverterRig rig(sensor);
  Planes planes(8, 1);
  planes.show_everywhere(3.0, 1500, 600);
  const PmdMaps& maps = rig.converter().convert(planes.samples());
  EXPECT_NEAR(maps.sigma.at(3, 0), 40 * (0.1 + 0.6 + 2.7), 1.5);
  EXPECT_EQ(maps.low.at(3, 0), maps.distance.at(3, 0) - 2 * maps.sigma.at(3, 0));
  planes.planes[2][5] = 4095;
  rig.converter().convert(planes.samples());
  EXPECT_EQ(maps.sigma.at(5, 0), 0);  // missing
}

TEST(ConverterFrame, UndoesTheWayOfLightsBesideTheLens) {
  PmdSensor sensor = frame_sensor(64, 16);
  sensor.emitter_count = 1;
  sensor.emitters[0] = {0.12, 0, 0};
  ConverterRig rig(sensor);
  Planes planes(64, 16);
  // The principal point looks straight ahead at 0.5 m: out sqrt(0.5^2 + 0.12^2), back 0.5.
  const double half_way = (std::hypot(0.5, 0.12) + 0.5) / 2;
  planes.show_everywhere(half_way, 1500, 600);
  const PmdMaps& maps = rig.converter().convert(planes.samples());
  EXPECT_NEAR(maps.distance.at(32, 8), 2000, 4);
  EXPECT_NEAR(half_way * 4000 - maps.distance.at(32, 8), 28, 6);  // 7 mm
}

TEST(ConverterFrame, CountsTurnsBeyondSixteenMetresInTheLongRange) {
  PmdSensor sensor = frame_sensor(9, 2);
  sensor.frequency.modulation = {5'000'000};  // 29.979 m a turn
  ConverterRig rig(sensor);
  Planes planes(9, 2);
  for (std::size_t i = 0; i < 18; ++i) {
    planes.show(i, i < 9 ? 25.0 : 10.0, 1500, 600, 5e6);
  }
  planes.planes[0][4] = 4095;
  const PmdMaps& maps = rig.converter().measure(frame_of({.samples = planes.samples()}));
  EXPECT_NEAR(maps.long_distance.at(2, 0), 250000, 45);
  EXPECT_EQ(maps.distance.at(2, 0), kNoDepth);
  EXPECT_EQ(maps.sigma.at(2, 0), 0);
  EXPECT_EQ(maps.flags.at(2, 0), kPmdOutOfRange);
  EXPECT_NEAR(maps.long_distance.at(2, 1), 100000, 45);
  EXPECT_NEAR(maps.distance.at(2, 1), 40000, 18);
  EXPECT_EQ(maps.long_distance.at(4, 0), 0U);  // saturated
  EXPECT_EQ(maps.range, 119917U);
}

PmdSensor two_frequency_sensor(int width, int height) {
  PmdSensor sensor = frame_sensor(width, height);
  sensor.second = PmdFrequency{.modulation = {18'750'000}};
  return sensor;
}

TEST(ConverterFrame, TellsTurnsApartWithTwoFrequencies) {
  const std::vector<double> distances{0.8, 7.3, 7.6, 11.0, 16.2, 16.5, 40.0, 100.0};
  PmdSensor sensor = two_frequency_sensor(8, 1);
  sensor.frequency.offset_m = 0.3;
  sensor.second->offset_m = 0.1;
  const std::vector<std::int16_t> pattern(8, 437);  // 50 mm, of both
  sensor.fixed_pattern = pattern;
  ConverterRig rig(sensor);
  Planes first(8, 1);
  Planes second(8, 1);
  for (std::size_t i = 0; i < 8; ++i) {
    first.show(i, distances[i] + 0.3 + 0.05, 1500, 1100);
    second.show(i, distances[i] + 0.1 + 0.05, 1500, 1100, 18.75e6);
  }
  const PmdExposure a{.samples = first.samples()};
  const PmdExposure b{.samples = second.samples()};
  const PmdMaps& maps = rig.converter().measure({.first = {&a, 1}, .second = {&b, 1}});
  for (int x = 0; x < 8; ++x) {
    const double metres = distances[static_cast<std::size_t>(x)];
    EXPECT_EQ(maps.flags.at(x, 0), metres > 16.38 ? kPmdOutOfRange : 0) << metres;
    EXPECT_NEAR(maps.long_distance.at(x, 0), metres * 10000, 20) << metres;
    EXPECT_NEAR(maps.distance.at(x, 0), metres > 16.38 ? 0 : metres * 4000, 8) << metres;
  }
  EXPECT_NEAR(maps.range, 119.917 * 4000, 5);
  EXPECT_EQ(maps.widest, 14989);  // half a turn of the first frequency, as before
  // Without the second frequency the first one's turn is all there is.
  rig.converter().measure({.first = {&a, 1}});
  EXPECT_NEAR(maps.distance.at(3, 0), (11.0 - kTurnM) * 4000, 5);
  EXPECT_EQ(maps.range, 29979U);
}

TEST(ConverterFrame, GivesNoDistanceWhereFrequenciesContradictEachOther) {
  ConverterRig rig(two_frequency_sensor(8, 1));
  Planes first(8, 1);
  Planes second(8, 1);
  first.show_everywhere(5.0, 1500, 1100);
  second.show_everywhere(5.0, 1500, 1100, 18.75e6);
  second.show(3, 5.0 + 0.45 * kTurnM / 15, 1500, 1100, 18.75e6);
  second.planes[1][6] = 4095;
  const PmdExposure a{.samples = first.samples()};
  const PmdExposure b{.samples = second.samples()};
  const PmdMaps& maps = rig.converter().convert({.first = {&a, 1}, .second = {&b, 1}});
  for (int x = 0; x < 8; ++x) {
    const bool missing = x == 3 || x == 6;
    EXPECT_EQ(maps.distance.at(x, 0) == kNoDepth, missing) << x;
    EXPECT_EQ(maps.long_distance.at(x, 0) == 0, missing) << x;
    EXPECT_EQ(maps.high.at(x, 0) == kNoDepth, missing) << x;
  }
  EXPECT_TRUE(maps.flags.at(3, 0) & kPmdWrapped);
  EXPECT_TRUE(maps.flags.at(6, 0) & kPmdSaturated);
}

// Both frequencies measure the same surface: their mean is better than each.
TEST(ConverterFrame, MakesSigmaOfTwoFrequenciesSmaller) {
  ConverterRig rig(two_frequency_sensor(8, 1));
  Planes first(8, 1);
  Planes second(8, 1);
  first.show_everywhere(5.0, 1500, 1100);
  second.show_everywhere(5.0, 1500, 1100, 18.75e6);
  const PmdExposure a{.samples = first.samples()};
  const PmdExposure b{.samples = second.samples()};
  const double alone = rig.converter().convert({.first = {&a, 1}}).sigma.at(4, 0);
  const PmdMaps& both = rig.converter().convert({.first = {&a, 1}, .second = {&b, 1}});
  const double other = alone * 20 / 18.75;
  EXPECT_NEAR(both.sigma.at(4, 0), alone * other / std::hypot(alone, other), 1);
}

TEST(ConverterFrame, TakesTheLongestExposureThatIsNotSaturated) {
  PmdSensor sensor = frame_sensor(16, 1);
  sensor.suppressed_lsb = 400;
  ConverterRig rig(sensor);
  Planes brief(16, 1);
  Planes middle(16, 1);
  Planes lengthy(16, 1);
  for (std::size_t i = 0; i < 16; ++i) {  // from dark to bright; 4095 - 100 is the most there is
    const double light = 40.0 * static_cast<double>(1U << (i / 2));
    brief.show(i, 2.0, light / 8, light / 20);
    middle.show(i, 2.0, light, light / 2.5);
    lengthy.show(i, 2.0, light * 4, light * 1.6);
  }
  const std::vector<PmdExposure> exposures{
      {brief.samples(), 64}, {lengthy.samples(), 2048}, {middle.samples(), 512}};
  const PmdMaps& maps = rig.converter().measure({.first = exposures});
  EXPECT_EQ(maps.integration, 2048);
  for (int x = 0; x < 16; ++x) {
    const double light = 40.0 * static_cast<double>(1U << static_cast<unsigned>(x / 2));
    EXPECT_EQ(maps.flags.at(x, 0), 0) << x;
    EXPECT_NEAR(maps.distance.at(x, 0), 8000, 60) << x;
    // As the longest exposure would have had it; that is 32 times the briefest, rounding too.
    EXPECT_NEAR(maps.amp2.at(x, 0), light * 3.2, 33) << x;
    EXPECT_NEAR(maps.offset.at(x, 0), light * 4, 33) << x;
    EXPECT_NEAR(maps.ratio.at(x, 0), 102, 3) << x;
  }
  // Noise is that of the exposure taken: pixel 13 took the middle one, 2560 of light and 1024.
  const double k = std::sqrt(2.0) * kTurnM * 4000 / (2 * 3.14159265358979);
  const double variance = 2560.0 / 61 + 400 * 2.0 / 61 + 25 + 1 / 12.0;
  EXPECT_NEAR(maps.sigma.at(13, 0), k * std::sqrt(variance) / 2048, 1.5);
}

TEST(ConverterFrame, SaysSaturatedWhereAllExposuresAre) {
  ConverterRig rig(frame_sensor(3, 3));
  Planes bright(3, 3);
  bright.show_everywhere(2.0, 4000, 2000);
  const std::vector<PmdExposure> exposures{{bright.samples(), 256}, {bright.samples(), 32}};
  const PmdMaps& maps = rig.converter().convert({.first = exposures});
  EXPECT_TRUE(maps.flags.at(1, 1) & kPmdSaturated);
  EXPECT_EQ(maps.distance.at(1, 1), kNoDepth);
}

// measure() and refresh_intervals() are convert(), and readings may be changed between both.
TEST(ConverterFrame, LetsReadingsBeMovedBeforeIntervals) {
  ConverterRig rig(frame_sensor(8, 3));
  Planes planes(8, 3);
  planes.show_everywhere(7.6, 1500, 600);  // read as 0.105 m
  const PmdMaps& maps = rig.converter().measure(frame_of({.samples = planes.samples()}));
  for (int y = 0; y < 3; ++y) {
    for (QuarterMm& d : maps.distance.row(y)) {
      EXPECT_NEAR(d, 421, 6);
      d = static_cast<QuarterMm>(d + maps.range);
    }
  }
  refresh_intervals(maps);
  EXPECT_NEAR(maps.distance.at(3, 1), 30400, 6);
  EXPECT_EQ(maps.flags.at(3, 1), 0);
  EXPECT_EQ(maps.high.at(3, 1), maps.distance.at(3, 1) + 2 * maps.sigma.at(3, 1));
}

// Everything at once, on noise and on extremes, from one pixel up: nothing faults, and what is
// missing is missing everywhere.
TEST(ConverterFrame, SurvivesNoiseWithEverySensor) {
  for (const auto& [w, h] : {std::pair{1, 1}, {2, 3}, {17, 2}, {33, 9}}) {
    PmdSensor sensor = two_frequency_sensor(w, h);
    sensor.emitter_count = 2;
    sensor.emitters[0] = {0.12, 0, 0};
    sensor.emitters[1] = {-0.12, 0.01, 0.02};
    sensor.scale = 0.97;
    sensor.shift_m = 0.4;
    sensor.frequency.stray_i_lsb = -300;
    sensor.second->stray_q_lsb = 9000;
    sensor.frequency.offset_m_per_k = -0.02;
    ConverterRig rig(sensor);
    test::Random random(static_cast<std::uint64_t>(w));
    std::vector<Planes> planes(4, Planes(w, h));
    for (Planes& one : planes) {
      for (std::vector<std::uint16_t>& plane : one.planes) {
        random.fill(std::span(plane), 0, random.between(0, 1) == 0 ? 4095 : 65535);
      }
    }
    const std::vector<PmdExposure> first{{planes[0].samples(), 1}, {planes[1].samples(), 65535}};
    const std::vector<PmdExposure> second{{planes[2].samples(), 300}, {planes[3].samples(), 300}};
    const PmdMaps& maps =
        rig.converter().convert({.first = first, .second = second, .temperature_q8 = -1000000});
    for (int y = 0; y < h; ++y) {
      for (int x = 0; x < w; ++x) {
        const bool missing = (maps.flags.at(x, y) & kPmdMissing) != 0;
        const bool far = !missing && (maps.flags.at(x, y) & kPmdOutOfRange) != 0 &&
                         maps.distance.at(x, y) == kNoDepth;
        ASSERT_EQ(missing || far, maps.distance.at(x, y) == kNoDepth);
        ASSERT_EQ(missing, maps.long_distance.at(x, y) == 0);
        ASSERT_EQ(missing || far, maps.high.at(x, y) == kNoDepth);
        ASSERT_EQ(missing || far, maps.sigma.at(x, y) == 0);
      }
    }
  }
}

}  // namespace
}  // namespace stof::dsp
