#include "dsp/fusion/interval/stereo_interval.h"

#include <algorithm>
#include <vector>

#include <gtest/gtest.h>

#include "dsp/calib/stereo/disparity_table.h"
#include "tests/support/kernel_check.h"

namespace stof::dsp {
namespace {

// f b = 100 px m: 10 px are 10 m, 50 px are 2 m.
constexpr StereoRig kRig{.left = {.width = 640, .height = 480, .fx = 1000, .fy = 1000},
                         .baseline_m = 0.1};

struct Lookup {
  explicit Lookup(const StereoRig& rig, QuarterMm max_range = 40000, std::uint8_t half = 16,
                  std::int16_t first = -16)
      : bounds(65 * 16 + 1 + 2 * kMostHalfWidth),
        table(make_disparity_table(rig, first, max_range, bounds)),
        spread(half) {}
  DepthInterval at(Disparity disparity) const {
    DepthInterval out{7, 7};
    best::stereo_interval({&disparity, 1}, {&spread, 1}, table, {&out.low, 1}, {&out.high, 1});
    return out;
  }
  std::vector<DepthInterval> bounds;
  DisparityTable table;
  std::uint8_t spread;
};

TEST(StereoInterval, IsAsymmetricAroundTwoMetres) {
  const DepthInterval interval = Lookup(kRig).at(Disparity::from_pixels(50));
  EXPECT_EQ(interval.low, 7843);   // 100 / 51 m = 1.96078
  EXPECT_EQ(interval.high, 8164);  // 100 / 49 m = 2.04082
}

TEST(StereoInterval, CountsFractionsAndTheDisparityOffset) {
  StereoRig rig = kRig;
  rig.doff_px = 40;
  const DepthInterval interval = Lookup(rig, 40000, 0).at(Disparity::from_raw(10 * 16 + 8));
  EXPECT_EQ(interval.low, 7920);  // 100 / 50.5 m = 1.98020
  EXPECT_EQ(interval.high, 7921);
}

TEST(StereoInterval, EndsAtTheLargestRange) {
  const Lookup lookup(kRig);
  EXPECT_EQ(lookup.at(Disparity::from_pixels(10)).high, 40000);  // far end at 11.1 m
  EXPECT_EQ(lookup.at(Disparity::from_pixels(10)).low, 36363);
  EXPECT_EQ(lookup.at(Disparity::from_pixels(9)).high, 0);  // wholly beyond 10 m
  EXPECT_EQ(lookup.at(Disparity::from_pixels(0)).high, 0);
  StereoRig behind = kRig;
  behind.doff_px = -9.5;  // d = 10: half a pixel from infinity, far end behind it
  EXPECT_EQ(Lookup(behind, 65535).at(Disparity::from_pixels(10)).high, 0);
  EXPECT_EQ(Lookup(behind, 65535, 200).at(Disparity::from_pixels(10)).high, 65535);
}

TEST(StereoInterval, IsAtLeastOneUnitAway) {
  StereoRig tiny = kRig;
  tiny.baseline_m = 1e-9;
  const DepthInterval interval = Lookup(tiny, 40000, 0).at(Disparity::from_pixels(50));
  EXPECT_EQ(interval.low, 1);
  EXPECT_EQ(interval.high, 1);
}

TEST(StereoInterval, OfNoDisparityAndOfUnknownOnesIsNone) {
  const Lookup lookup(kRig);
  EXPECT_EQ(lookup.at(Disparity::none()).high, 0);
  EXPECT_EQ(lookup.at(Disparity::from_raw(-17)).high, 0);
  EXPECT_EQ(lookup.at(Disparity::from_raw(-32767)).high, 0);
  EXPECT_EQ(lookup.at(Disparity::from_raw(64 * 16 + 1)).high, 0);
  EXPECT_NE(lookup.at(Disparity::from_raw(64 * 16)).high, 0);
}

TEST(StereoInterval, WidensWithTheSpread) {
  const Lookup narrow(kRig, 40000, 0);
  EXPECT_EQ(narrow.at(Disparity::from_pixels(50)).low, 8000);
  EXPECT_EQ(narrow.at(Disparity::from_pixels(50)).high, 8000);
  const Lookup widest(kRig, 40000, kMostHalfWidth);
  EXPECT_EQ(widest.at(Disparity::from_pixels(50)).low, 6066);    // 100 / 65.9375 m
  EXPECT_EQ(widest.at(Disparity::from_pixels(50)).high, 11744);  // 100 / 34.0625 m
  EXPECT_EQ(widest.at(Disparity::from_pixels(64)).low, 5003);    // the table reaches beyond its end
}

TEST(StereoInterval, EqualsReferenceForEveryLengthAndAnyDisparity) {
  for (const int first : {-32767, -300, -16, 0, 5000, 32000}) {
    test::check_kernel([&](test::KernelCase& c) {
      const std::size_t n = c.length();
      const std::size_t size =
          2 * kMostHalfWidth + static_cast<std::size_t>(c.random().between(1, 900));
      const auto bounds = c.array<DepthInterval>(size + size % 2);
      const auto half = c.array<std::uint8_t>(n, 0, 255);
      const auto disparity = c.array<Disparity>(n);
      for (Disparity& d : disparity) {
        const int near = std::clamp(first + c.random().between(-2, 900), -32768, 32767);
        d = c.random().between(0, 2) == 0 ? d
                                          : Disparity::from_raw(static_cast<std::int16_t>(near));
      }
      const DisparityTable table{.first_raw = static_cast<std::int16_t>(first),
                                 .max_range = static_cast<QuarterMm>(c.draw(0, 65535)),
                                 .bounds = bounds};
      const auto low = c.array<QuarterMm>(n), high = c.array<QuarterMm>(n);
      c.run([&] { best::stereo_interval(disparity, half, table, low, high); });
    });
  }
}

}  // namespace
}  // namespace stof::dsp
