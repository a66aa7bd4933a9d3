#include "hal/emu/scenes/scene.h"

#include <cmath>
#include <numbers>

#include <gtest/gtest.h>

#include "hal/emu/imagery/noise.h"
#include "hal/emu/imagery/phasor.h"
#include "hal/emu/scenes/intersect.h"
#include "hal/emu/scenes/viewpoint.h"

namespace stof::test {
namespace {

using namespace hal::emu;

constexpr double kExact = 1e-12;  // a few roundings of doubles of size 1

void expect_near(const Vec3& a, const Vec3& b) {
  EXPECT_NEAR(a.x, b.x, kExact);
  EXPECT_NEAR(a.y, b.y, kExact);
  EXPECT_NEAR(a.z, b.z, kExact);
}

double degrees(double angle) { return std::tan(angle * std::numbers::pi / 360); }

TEST(Pose, TurnsRightUpAndClockwise) {
  expect_near(turned(degrees(30)).turn({0, 0, 1}), {0.5, 0, std::sqrt(0.75)});
  expect_near(turned(0, degrees(30)).turn({0, 0, 1}), {0, -0.5, std::sqrt(0.75)});
  expect_near(turned(0, 0, degrees(90)).turn({1, 0, 0}), {0, 1, 0});
  expect_near(turned(0.3, -0.2, 0.7).turn_back(turned(0.3, -0.2, 0.7).turn({1, 2, 3})), {1, 2, 3});
}

TEST(Pose, ProductAppliesTheRightOneFirst) {
  Pose a = turned(0.2, 0.1);
  a.position = {1, 2, 3};
  Pose b = turned(-0.4, 0, 0.3);
  b.position = {-1, 0, 2};
  expect_near((a * b).apply({5, 6, 7}), a.apply(b.apply({5, 6, 7})));
  expect_near(a.undo(a.apply({5, 6, 7})), {5, 6, 7});
}

TEST(Intersect, RectangleIsHitFromBothSidesAndInsideOnly) {
  const Vec3 half{1, 2, 0};
  EXPECT_DOUBLE_EQ(intersect(Shape::kRectangle, half, {0.5, 1, -3}, {0, 0, 1}).t, 3);
  expect_near(intersect(Shape::kRectangle, half, {0, 0, -3}, {0, 0, 1}).normal, {0, 0, -1});
  expect_near(intersect(Shape::kRectangle, half, {0, 0, 3}, {0, 0, -1}).normal, {0, 0, 1});
  EXPECT_LT(intersect(Shape::kRectangle, half, {1.01, 0, -3}, {0, 0, 1}).t, 0);
  EXPECT_LT(intersect(Shape::kRectangle, half, {0, 0, -3}, {1, 0, 0}).t, 0);
  EXPECT_LT(intersect(Shape::kRectangle, half, {0, 0, 3}, {0, 0, 1}).t, 0) << "behind";
}

TEST(Intersect, BoxShowsTheFaceThatIsHit) {
  const Vec3 half{1, 2, 3};
  const LocalHit front = intersect(Shape::kBox, half, {0.2, 0.3, -10}, {0, 0, 2});
  EXPECT_DOUBLE_EQ(front.t, 3.5);
  expect_near(front.normal, {0, 0, -1});
  const LocalHit side = intersect(Shape::kBox, half, {11, 0, 0}, {-1, 0, 0});
  EXPECT_DOUBLE_EQ(side.t, 10);
  expect_near(side.normal, {1, 0, 0});
  EXPECT_NE(front.face, side.face);
  EXPECT_LT(intersect(Shape::kBox, half, {1.5, 0, -10}, {0, 0, 1}).t, 0);
}

TEST(Intersect, CylinderHasASideAndCaps) {
  const Vec3 half{0.5, 1, 0.25};
  const LocalHit side = intersect(Shape::kCylinder, half, {0, 0, -2}, {0, 0, 1});
  EXPECT_DOUBLE_EQ(side.t, 1.75);
  expect_near(side.normal, {0, 0, -1});
  const LocalHit top = intersect(Shape::kCylinder, half, {0.1, -5, 0.1}, {0, 1, 0});
  EXPECT_DOUBLE_EQ(top.t, 4);
  expect_near(top.normal, {0, -1, 0});
  EXPECT_LT(intersect(Shape::kCylinder, half, {0.51, 0, -2}, {0, 0, 1}).t, 0);
  EXPECT_LT(intersect(Shape::kCylinder, half, {0.4, -5, 0.2}, {0, 1, 0}).t, 0) << "beside the cap";
}

TEST(Intersect, EllipsoidHasItsRadii) {
  const Vec3 half{0.5, 1, 2};
  EXPECT_DOUBLE_EQ(intersect(Shape::kEllipsoid, half, {-3, 0, 0}, {1, 0, 0}).t, 2.5);
  EXPECT_DOUBLE_EQ(intersect(Shape::kEllipsoid, half, {0, -3, 0}, {0, 1, 0}).t, 2);
  EXPECT_DOUBLE_EQ(intersect(Shape::kEllipsoid, half, {0, 0, -3}, {0, 0, 1}).t, 1);
  expect_near(intersect(Shape::kEllipsoid, half, {0, 0, -3}, {0, 0, 1}).normal, {0, 0, -1});
  EXPECT_LT(intersect(Shape::kEllipsoid, half, {0.6, 0, -3}, {0, 0, 1}).t, 0);
}

TEST(Viewpoint, SeesTheNearestThingAndItsDepth) {
  Scene scene = wall(4);
  scene.objects.push_back(
      {.shape = Shape::kBox, .pose = {.position = {1, 0, 3}}, .half = {0.5, 0.5, 1}});
  Pose pose = turned(0);
  pose.position = {0, 0, 1};
  const Viewpoint viewpoint(scene, pose);
  EXPECT_DOUBLE_EQ(viewpoint.look(0, 0).t, 3);
  EXPECT_EQ(viewpoint.look(0, 0).object, 0);
  EXPECT_DOUBLE_EQ(viewpoint.look(0.9, 0).t, 1);
  EXPECT_EQ(viewpoint.look(0.9, 0).object, 1);
  expect_near(viewpoint.look(0.9, 0).point, {0.9, 0, 2});
  EXPECT_EQ(viewpoint.look_at(0, 0.9, 0).object, 0);
  EXPECT_EQ(viewpoint.look_at(1, 0, 0).object, -1);
}

TEST(Viewpoint, SkipsNothingThatALookWithoutBoundsWouldHit) {
  const Scene scene = corridor();
  Pose pose = turned(-0.05, 0.02, 0.01);
  pose.position = {0.1, -1.1, 0.3};
  const Viewpoint viewpoint(scene, pose);
  for (int i = 0; i < 4000; ++i) {
    const int column = i % 80;
    const int row = i / 80;
    const double x = (column - 40) / 50.0;
    const double y = (row - 25) / 40.0;
    double nearest = -1;
    for (int object = 0; object < static_cast<int>(scene.objects.size()); ++object) {
      const Hit hit = viewpoint.look_at(object, x, y);
      if (hit.object >= 0 && (nearest < 0 || hit.t < nearest)) {
        nearest = hit.t;
      }
    }
    const Hit seen = viewpoint.look(x, y);
    ASSERT_EQ(seen.object < 0 ? -1 : seen.t, nearest) << x << " " << y;
  }
}

TEST(Viewpoint, LooksPastAThingAsIfItWereNotThere) {
  Scene scene = wall(4);
  add(scene, Shape::kRectangle, {0, 0, 2}, {1, 1, 0}, {});
  const Viewpoint viewpoint(scene, {});
  EXPECT_EQ(viewpoint.look(0.1, 0).object, 1);
  EXPECT_EQ(viewpoint.look_past(1, 0.1, 0).object, 0);
  EXPECT_DOUBLE_EQ(viewpoint.look_past(1, 0.1, 0).t, 4);
  EXPECT_EQ(viewpoint.look_past(0, 3, 0).object, -1);
}

TEST(Texture, RepetitiveOnesRepeatAndNoiseDoesNot) {
  Material material{.albedo = 0.8, .contrast = 0.5, .texture = Texture::kStripes, .period_m = 0.1};
  const auto at = [&](double x, double y) { return visible_albedo(material, {x, y, 0.013}); };
  EXPECT_EQ(at(0.02, 0), at(0.12, 0.5));
  EXPECT_NE(at(0.02, 0), at(0.07, 0));
  material.texture = Texture::kChecks;
  EXPECT_EQ(at(0.02, 0.01), at(0.12, 0.11));
  EXPECT_EQ(at(0.02, 0.01), at(0.07, 0.06));
  EXPECT_NE(at(0.02, 0.01), at(0.02, 0.06));
  material.texture = Texture::kNoise;
  int equal = 0;
  for (int i = 0; i < 100; ++i) {
    equal += at(0.01 * i, 0) == at(0.01 * i + 0.1, 0) ? 1 : 0;
    EXPECT_GE(at(0.01 * i, 0), 0.8 * 0.5);
    EXPECT_LE(at(0.01 * i, 0), 0.8);
  }
  EXPECT_LT(equal, 10);
}

TEST(Texture, SpeckleIsFinerThanNoise) {
  const auto change = [](Texture texture) {
    const Material material{.albedo = 1, .contrast = 1, .texture = texture, .period_m = 0.4};
    double sum = 0;
    for (int i = 0; i < 400; ++i) {
      const double here = visible_albedo(material, {0.01 * i, 0, 0});
      EXPECT_GE(here, 0);
      EXPECT_LE(here, 1);
      sum += std::abs(here - visible_albedo(material, {0.01 * i + 0.002, 0, 0}));
    }
    return sum / 400;
  };
  EXPECT_GT(change(Texture::kSpeckle), 4 * change(Texture::kNoise));
}

TEST(Texture, InfraredMayBlindThePattern) {
  const Material cloth{
      .albedo = 0.8, .contrast = 1, .texture = Texture::kStripes, .period_m = 0.1, .nir = 0.6};
  EXPECT_EQ(infrared_albedo(cloth, {0.02, 0, 0}), 0.6);
  EXPECT_EQ(infrared_albedo(cloth, {0.07, 0, 0}), 0.6);
  const Material same{.albedo = 0.3};
  EXPECT_EQ(infrared_albedo(same, {}), 0.3);
}

TEST(Radiance, IsLambertsLawPlusAmbient) {
  Scene scene = wall(2, {.albedo = 0.5});
  scene.ambient = 0.25;
  scene.lights.push_back({.position = {0, 0, 0}, .power = 8});
  const Viewpoint viewpoint(scene, {});
  EXPECT_NEAR(radiance(scene, viewpoint.look(0, 0), {}), 0.5 * (0.25 + 8 / 4.0), kExact);
  // 45 degrees aside: twice the square of the distance, cosine 1 / sqrt 2.
  EXPECT_NEAR(radiance(scene, viewpoint.look(1, 0), {}), 0.5 * (0.25 + 1 / std::sqrt(2.0)), kExact);
}

TEST(Radiance, GlossMirrorsTheLight) {
  Scene scene = wall(2, {.albedo = 0, .gloss = 1, .gloss_log2 = 8});
  scene.lights.push_back({.position = {1, 0, 0}, .power = 1});
  const Viewpoint viewpoint(scene, {});
  const double mirrored =
      radiance(scene, viewpoint.look(0.25, 0), {});  // x = 0.5: halfway to the light
  EXPECT_NEAR(mirrored, 129 / 4.25, kExact);
  EXPECT_LT(radiance(scene, viewpoint.look(0.4, 0), {}), 0.5 * mirrored);
  EXPECT_LT(radiance(scene, viewpoint.look(0.1, 0), {}), 0.5 * mirrored);
}

TEST(Phasor, EqualsTheLibrarysSineAndCosine) {
  for (int i = -3000; i <= 3000; ++i) {
    const double turns = i / 777.0;
    const Phasor p = phasor(turns);
    ASSERT_NEAR(p.re, std::cos(2 * std::numbers::pi * turns), 1e-12) << turns;
    ASSERT_NEAR(p.im, std::sin(2 * std::numbers::pi * turns), 1e-12) << turns;
  }
}

}  // namespace
}  // namespace stof::test
