#include "dsp/calib/stereo/column_tables.h"

#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "dsp/calib/stereo/disparity_table.h"
#include "dsp/fusion/interval/stereo_interval.h"

namespace stof::dsp {
namespace {

// Kuhnert & Stommel 2006, table 2: b F cos^2(alpha) = 1.704e-3 m with pixels of 5.6 um is 0.20 m
// and 8.52 mm; axes meet at 5.31 m.
StereoRig chapter_rig(int width = 640) {
  StereoRig rig;
  rig.left = {.width = width, .height = 480, .fy = 1521.4, .cy = 239.5};
  rig.baseline_m = 0.20;
  const double half = std::atan(0.10 / 5.31);
  rig.converging = Converging{.alpha_rad = half,
                              .beta_rad = -half,
                              .f1_m = 8.52e-3,
                              .f2_m = 8.52e-3,
                              .pixel_m = 5.6e-6,
                              .cx_left = (width - 1) / 2.0,
                              .cx_right = (width - 1) / 2.0};
  EXPECT_STREQ(complete(rig), "");
  return rig;
}

// Unequal in everything.
StereoRig crooked_rig(int width) {
  StereoRig rig = chapter_rig(width);
  rig.converging = Converging{.alpha_rad = 0.12,
                              .beta_rad = -0.05,
                              .f1_m = 4.1e-3,
                              .f2_m = 3.9e-3,
                              .pixel_m = 6e-6,
                              .cx_left = width * 0.46,
                              .cx_right = width * 0.55};
  EXPECT_STREQ(complete(rig), "");
  return rig;
}

struct Lookup {
  Lookup(const StereoRig& rig, int width, int first, int last, int sigma, QuarterMm max_range)
      : left(static_cast<std::size_t>(width)),
        right(right_tangents(left.size(), first, last)),
        half(left.size(), static_cast<std::uint8_t>(2 * sigma)),
        tables(make_column_tables(rig, static_cast<std::int16_t>(first),
                                  static_cast<std::int16_t>(last), max_range, left, right)) {}
  // The same disparity in the whole row.
  std::vector<DepthInterval> row(int raw) const {
    const std::vector<Disparity> disparity(left.size(),
                                           Disparity::from_raw(static_cast<std::int16_t>(raw)));
    std::vector<QuarterMm> low(left.size()), high(left.size());
    ref::column_interval(disparity, half, tables, low, high);
    std::vector<DepthInterval> out(left.size());
    for (std::size_t x = 0; x < out.size(); ++x) {
      out[x] = {low[x], high[x]};
    }
    return out;
  }
  std::vector<std::int32_t> left, right;
  std::vector<std::uint8_t> half;
  ColumnTables tables;
};

TEST(ColumnTables, AxesOfTheChaptersRigMeetWhereTheChapterSays) {
  const StereoRig rig = chapter_rig();
  EXPECT_NEAR(depth_of(rig, 319.5, 0), 5.31, 1e-9);
  const Converging& c = *rig.converging;
  EXPECT_NEAR(rig.baseline_m * c.f1_m * std::pow(std::cos(c.alpha_rad), 2), 1.704e-3, 1e-6);
  EXPECT_GT(depth_of(rig, 319.5, -20), 5.31);  // behind the crossing: negative disparities
  EXPECT_LT(depth_of(rig, 319.5, 20), 5.31);
  EXPECT_TRUE(std::isinf(depth_of(rig, 319.5, -58)));  // 57.3 px: the axes' own angle
}

// The formula of the rig itself, nothing shared with the code.
double formula(const StereoRig& rig, double x, double d) {
  const Converging& c = *rig.converging;
  const double right =
      std::tan(c.alpha_rad + std::atan(-(x - d - c.cx_right) * c.pixel_m / c.f1_m));
  const double left = std::tan(c.beta_rad + std::atan(-(x - c.cx_left) * c.pixel_m / c.f2_m));
  return right - left <= 0 ? std::numeric_limits<double>::infinity()
                           : rig.baseline_m / (right - left);
}

TEST(ColumnTables, DepthOfOnePixelIsTheFormula) {
  for (const StereoRig& rig : {chapter_rig(), crooked_rig(640)}) {
    for (double x = 0; x < 640; x += 37.25) {
      for (double d = -120; d < 120; d += 3.125) {
        const double want = formula(rig, x, d);
        const double got = depth_of(rig, x, d);
        if (std::isinf(want) || want > 1e9) {
          EXPECT_GT(got, 1e9);
        } else {
          EXPECT_NEAR(got, want, 1e-12 * want * want + 1e-12);
        }
      }
    }
  }
}

// Holds the exact interval, and ends at most 1 + Z^2 / (b 2^27) further out; all columns and all
// disparities, negative ones too.
void expect_bounds(const StereoRig& rig, int width, int first, int last, int sigma) {
  constexpr QuarterMm kRange = 40000;
  const Lookup lookup(rig, width, first, last, sigma, kRange);
  const double b = rig.baseline_m * kQuarterMmPerMetre;
  const auto slack = [&](double z) { return 1 + z * z / b / (1 << 27); };
  int some = 0;
  for (int raw = first; raw <= last; ++raw) {
    const std::vector<DepthInterval> row = lookup.row(raw);
    for (int x = 0; x < width; ++x) {
      const DepthInterval got = row[static_cast<std::size_t>(x)];
      const double near = kQuarterMmPerMetre * formula(rig, x, (raw + 2 * sigma) / 16.0);
      const double far = kQuarterMmPerMetre * formula(rig, x, (raw - 2 * sigma) / 16.0);
      if (got.high == 0) {
        ASSERT_GE(near + slack(near), kRange) << x << ", " << raw;
        continue;
      }
      ASSERT_LT(near - slack(near), kRange) << x << ", " << raw;
      ASSERT_LE(got.low, std::max(near, 1.0)) << x << ", " << raw;
      ASSERT_GE(got.low, near - slack(near)) << x << ", " << raw;
      ASSERT_GE(got.high, std::min<double>(far, kRange)) << x << ", " << raw;
      if (got.high < kRange) {
        ASSERT_LE(got.high, far + slack(far)) << x << ", " << raw;
      } else {
        ASSERT_GE(far + slack(far), kRange) << x << ", " << raw;
      }
      ++some;
    }
  }
  EXPECT_GT(some, width * (last - first) / 4);
}

TEST(ColumnTables, HoldTheFormulasIntervalForEveryColumnAndDisparity) {
  expect_bounds(chapter_rig(320), 320, -60 * 16, 70 * 16, 8);
  expect_bounds(crooked_rig(200), 200, -90 * 16, 30 * 16, 5);
  StereoRig narrow = chapter_rig(64);
  narrow.baseline_m = 0.001;  // coarse steps of Z: the slack matters
  expect_bounds(narrow, 64, -60 * 16, 70 * 16, 0);
}

TEST(ColumnTables, IntervalIsLongerOnTheFarSide) {
  const StereoRig rig = chapter_rig();
  const Lookup lookup(rig, 640, -60 * 16, 70 * 16, 8, 65535);
  for (const int x : {0, 319, 639}) {
    const double z = kQuarterMmPerMetre * depth_of(rig, x, 0);
    const DepthInterval at = lookup.row(0)[static_cast<std::size_t>(x)];
    EXPECT_GT(at.high - z, z - at.low + 2) << x;
    // One pixel either way, f b = 304.3 px m: Z^2 / (f b -+ Z), but for the slope of T at the edge.
    EXPECT_NEAR(at.high - z, z * z / (304.3 * 4000 - z), 5) << x;
    EXPECT_NEAR(z - at.low, z * z / (304.3 * 4000 + z), 5) << x;
  }
}

// Rectified rigs need no columns; through columns they give the same within the rounding.
TEST(ColumnTables, OfAParallelRigEqualTheDisparityTableWithinOneUnit) {
  StereoRig rig;
  rig.left = {.width = 320, .height = 240, .fx = 500, .fy = 500, .cx = 161.3, .cy = 119.5};
  rig.baseline_m = 0.12;
  for (const double doff : {0.0, 12.5, -7.25}) {
    rig.doff_px = doff;
    constexpr int kFirst = -16 * 16;
    constexpr int kLast = 64 * 16;
    constexpr QuarterMm kRange = 40000;
    const Lookup lookup(rig, 320, kFirst, kLast, 8, kRange);
    std::vector<DepthInterval> bounds(kLast - kFirst + 1 + 2 * kMostHalfWidth);
    const DisparityTable table = make_disparity_table(rig, kFirst, kRange, bounds);
    for (int raw = kFirst; raw <= kLast; ++raw) {
      const DepthInterval want = table.at(raw, 16);
      for (const DepthInterval got : lookup.row(raw)) {
        const bool at_the_end = want.low >= kRange - 1 || got.low >= kRange - 1;
        if (want.high == 0 || got.high == 0) {
          ASSERT_TRUE(want.high == got.high || at_the_end) << raw;
          continue;
        }
        ASSERT_LE(got.low, want.low) << raw;
        ASSERT_GE(got.low, want.low - 1) << raw;
        ASSERT_GE(got.high, want.high) << raw;
        ASSERT_LE(got.high, want.high + 1) << raw;
      }
    }
  }
}

TEST(ColumnTables, DisparitiesOutsideAndNoneHaveNoInterval) {
  const StereoRig rig = chapter_rig(64);
  const Lookup lookup(rig, 64, -16, 160, 8, 40000);
  for (const int raw : {-32768, -32767, -17, 161, 32767}) {
    for (const DepthInterval got : lookup.row(raw)) {
      ASSERT_EQ(got.high, 0) << raw;
      ASSERT_EQ(got.low, 0) << raw;
    }
  }
  EXPECT_NE(lookup.row(-16)[0].high, 0);
  EXPECT_NE(lookup.row(160)[63].high, 0);
}

TEST(ColumnTables, RaysBeyond75DegreesAreNotUsed) {
  StereoRig rig = chapter_rig(640);
  rig.converging->f1_m = rig.converging->f2_m = 0.4e-3;  // half the picture is 77 degrees
  EXPECT_NE(std::string(complete(rig)), "");
  EXPECT_TRUE(std::isnan(left_tangent(rig, 0)));
  EXPECT_TRUE(std::isnan(depth_of(rig, 639, 0)));
  const Lookup lookup(rig, 640, 0, 16, 0, 40000);
  EXPECT_EQ(lookup.left[0], kNoLeftRay);
  EXPECT_EQ(lookup.row(16)[0].high, 0);
  EXPECT_EQ(lookup.row(16)[639].high, 0);
  EXPECT_NE(lookup.row(16)[320].high, 0);
}

TEST(Converging, NearestParallelRigAgreesAroundThePrincipalColumns) {
  const StereoRig rig = chapter_rig();
  StereoRig parallel = rig;
  parallel.converging.reset();
  EXPECT_NEAR(depth_of(parallel, 319.5, 0), 5.31, 1e-6);
  EXPECT_NEAR(depth_of(parallel, 319.5, 30) / depth_of(rig, 319.5, 30), 1, 1e-3);
  EXPECT_NEAR(left_tangent(parallel, 319.5), left_tangent(rig, 319.5), 1e-12);
  // At the edges of the picture, 12 degrees off the axis, a place is off by f tan(beta) tan^2(12).
  EXPECT_NEAR((left_tangent(parallel, 0) - left_tangent(rig, 0)) * rig.left.fx, 0, 1.4);
  EXPECT_NEAR((left_tangent(parallel, 639) - left_tangent(rig, 639)) * rig.left.fx, 0, 1.4);
}

TEST(Converging, WhatCannotBeComputedWithIsNamed) {
  const auto wrong = [](const auto& change) {
    StereoRig rig = chapter_rig();
    change(rig);
    return std::string(complete(rig));
  };
  const double nan = std::nan("");
  EXPECT_EQ(wrong([](StereoRig&) {}), "");
  EXPECT_NE(wrong([&](StereoRig& r) { r.converging->alpha_rad = nan; }), "");
  EXPECT_NE(wrong([&](StereoRig& r) { r.converging->beta_rad = -1.5; }), "");
  EXPECT_NE(wrong([&](StereoRig& r) { r.converging->f1_m = 0; }), "");
  EXPECT_NE(wrong([&](StereoRig& r) { r.converging->f2_m = -1; }), "");
  EXPECT_NE(wrong([&](StereoRig& r) { r.converging->pixel_m = nan; }), "");
  EXPECT_NE(wrong([&](StereoRig& r) { r.converging->cx_left = nan; }), "");
  EXPECT_NE(wrong([&](StereoRig& r) { r.converging->cx_right = 1e9; }), "");
  EXPECT_NE(wrong([&](StereoRig& r) { r.baseline_m = 0; }), "");
  EXPECT_NE(wrong([&](StereoRig& r) { r.baseline_m = 1000; }), "");
  EXPECT_NE(wrong([&](StereoRig& r) { r.raw.emplace(); }), "");
}

}  // namespace
}  // namespace stof::dsp
