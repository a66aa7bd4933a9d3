#include "dsp/calib/pmd/ray_table.h"

#include <cmath>
#include <numbers>
#include <vector>

#include <gtest/gtest.h>

namespace stof::dsp {
namespace {

constexpr Pinhole kChapter{
    .width = 64, .height = 16, .fx = 45.279, .fy = 45.279, .cx = 32.8, .cy = 10.0, .k1 = -0.1};

TEST(UnitRay, OfThePrincipalPointLooksStraightAhead) {
  const std::array<double, 3> ray = unit_ray(kChapter, 32.8, 10.0);
  EXPECT_EQ(ray[0], 0);
  EXPECT_EQ(ray[1], 0);
  EXPECT_EQ(ray[2], 1);
}

TEST(UnitRay, ReachesTheHalfApertureAtTheBorder) {
  // 70.5 degrees over 64 columns; half a pixel outside the first centre, without distortion.
  const Pinhole plain{.width = 64, .height = 16, .fx = 45.279, .fy = 45.279, .cx = 31.5, .cy = 7.5};
  const std::array<double, 3> ray = unit_ray(plain, -0.5, 7.5);
  EXPECT_NEAR(std::atan2(-ray[0], ray[2]) * 180 / std::numbers::pi, 35.25, 0.001);
}

TEST(UnitRay, ComesBackToItsPixelThroughTheDistortion) {
  for (int v = 0; v < 16; ++v) {
    for (int u = 0; u < 64; ++u) {
      const std::array<double, 3> ray = unit_ray(kChapter, u, v);
      EXPECT_NEAR(ray[0] * ray[0] + ray[1] * ray[1] + ray[2] * ray[2], 1, 1e-12);
      const double x = ray[0] / ray[2];
      const double y = ray[1] / ray[2];
      const double s = 1 - 0.1 * (x * x + y * y);
      ASSERT_NEAR(kChapter.fx * x * s + kChapter.cx, u, 0.01);
      ASSERT_NEAR(kChapter.fy * y * s + kChapter.cy, v, 0.01);
    }
  }
}

// Brown's model, written out once more.
void expect_comes_back(const Pinhole& lens, double u, double v) {
  const std::array<double, 3> ray = unit_ray(lens, u, v);
  ASSERT_GT(ray[2], 0) << u << "," << v;
  const double x = ray[0] / ray[2];
  const double y = ray[1] / ray[2];
  const double r2 = x * x + y * y;
  const double s = 1 + lens.k1 * r2 + lens.k2 * r2 * r2 + lens.k3 * r2 * r2 * r2;
  const double bent_x = x * s + 2 * lens.p1 * x * y + lens.p2 * (r2 + 2 * x * x);
  const double bent_y = y * s + lens.p1 * (r2 + 2 * y * y) + 2 * lens.p2 * x * y;
  ASSERT_NEAR(lens.fx * bent_x + lens.cx, u, 1e-6);
  ASSERT_NEAR(lens.fy * bent_y + lens.cy, v, 1e-6);
}

void expect_whole_picture_comes_back(const Pinhole& lens) {
  for (int v = 0; v < lens.height; ++v) {
    for (int u = 0; u < lens.width; ++u) {
      expect_comes_back(lens, u, v);
    }
  }
}

// The intrinsics of an ifm O3R's 224 x 172 head (k1, k2, p1, p2, k3 = 0.31, -0.144, 0, 0, 0.187):
// its corners are bent outwards by a third, where an iteration x <- x_d / s turns in circles.
TEST(UnitRay, StraightensTheLensOfARealCameraUpToItsCorners) {
  const Pinhole lens{.width = 224,
                     .height = 172,
                     .fx = 124.34428,
                     .fy = 124.34428,
                     .cx = 111.5,
                     .cy = 85.5,
                     .k1 = 0.309874,
                     .k2 = -0.143910,
                     .k3 = 0.186653};
  expect_whole_picture_comes_back(lens);
}

TEST(UnitRay, StraightensBarrelsAndLensesThatAreNotCentred) {
  Pinhole lens{.width = 160, .height = 120, .fx = 100, .fy = 110, .cx = 83, .cy = 57};
  lens.k1 = -0.3;
  lens.k2 = 0.12;
  lens.k3 = -0.02;
  lens.p1 = 0.004;
  lens.p2 = -0.006;
  expect_whole_picture_comes_back(lens);
  lens.k1 = 0.6;
  lens.k2 = 0.4;
  lens.p1 = -0.02;
  expect_whole_picture_comes_back(lens);
}

// Behind the fold the radius grows again, so there is a point that bends to (u, v): not the one.
TEST(UnitRay, IsNoneBehindAFoldThatUnfolds) {
  Pinhole lens = kChapter;
  lens.k1 = -1;
  lens.k2 = 0.3;  // x (1 - x^2 + 0.3 x^4): up to 0.41 at 0.65, then down, and up again behind 1.2
  EXPECT_EQ(unit_ray(lens, 32.8 + 0.6 * 45.279, 10)[2], 0);
  expect_comes_back(lens, 32.8 + 0.3 * 45.279, 10);
}

TEST(UnitRay, IsNoneWhereTheDistortionFoldsOver) {
  Pinhole lens = kChapter;
  lens.k1 = -1;  // x (1 - x^2) never exceeds 0.385
  const std::array<double, 3> inside = unit_ray(lens, 32.8 + 0.3 * 45.279, 10);
  EXPECT_GT(inside[2], 0);
  const std::array<double, 3> outside = unit_ray(lens, 32.8 + 0.6 * 45.279, 10);
  EXPECT_EQ(outside[2], 0);
}

TEST(RayTable, TurnsRaysIntoTheStereoAxes) {
  const std::size_t n = 64 * 16;
  std::vector<std::int16_t> x(n), y(n), z(n), forward(n);
  // A quarter turn about y: what is ahead of the PMD camera is to the right of the left one.
  fill_ray_table(kChapter, {0, 0, 1, 0, 1, 0, -1, 0, 0}, {x, y, z, forward});
  for (int i = 0; i < 64 * 16; ++i) {
    const int row = i / 64;
    const std::array<double, 3> ray = unit_ray(kChapter, i % 64, row);
    const std::size_t at = static_cast<std::size_t>(i);
    ASSERT_NEAR(x[at], ray[2] * 32768, 1);
    ASSERT_NEAR(y[at], ray[1] * 32768, 1);
    ASSERT_NEAR(z[at], -ray[0] * 32768, 1);
    ASSERT_EQ(forward[at], x[at]);
  }
}

}  // namespace
}  // namespace stof::dsp
