#include "hal/emu/imagery/grey.h"

#include <algorithm>
#include <cmath>

#include <gtest/gtest.h>

namespace stof::test {
namespace {

using namespace hal::emu;

constexpr dsp::Pinhole kLens{
    .width = 120, .height = 30, .fx = 500, .fy = 500, .cx = 59.5, .cy = 14.5};
const LensRays kRays(kLens);
constexpr double kBaseline = 0.12;  // 30 px at 2 m, 60 px at 1 m
constexpr Material kTextured{.contrast = 0.9, .texture = Texture::kNoise, .period_m = 0.02};

Pose right_of(const Pose& left) { return left * Pose{.position = {kBaseline, 0, 0}}; }

double level(const dataset::Image<std::uint16_t>& image, int x, int y) {
  return image.view().at(x, y) / static_cast<double>(1 << kGreyBits);
}

TEST(RenderGrey, WallAtTwoMetresIsShiftedByItsDisparity) {
  const Scene scene = wall(2, kTextured);
  const auto left = render_grey(scene, Viewpoint(scene, {}), kRays, {});
  const auto right = render_grey(scene, Viewpoint(scene, right_of({})), kRays, {});
  double contrast = 0;
  for (int y = 0; y < kLens.height; ++y) {
    for (int x = 30; x < kLens.width; ++x) {
      // Both see the same points but for the rounding of coordinates.
      ASSERT_NEAR(level(left, x, y), level(right, x - 30, y), 0.02) << x << " " << y;
      contrast = std::max(contrast, std::abs(level(left, x, y) - level(left, x - 30, y)));
    }
  }
  EXPECT_GT(contrast, 20) << "a flat picture would match at any shift";
}

TEST(RenderGrey, PrincipalPointsMoveTheDisparity) {
  const Scene scene = wall(2, kTextured);
  dsp::Pinhole shifted = kLens;
  shifted.cx += 5;  // doff 5: disparity 25
  const auto left = render_grey(scene, Viewpoint(scene, {}), kRays, {});
  const auto right = render_grey(scene, Viewpoint(scene, right_of({})), LensRays(shifted), {});
  for (int x = 25; x < kLens.width; ++x) {
    ASSERT_NEAR(level(left, x, 10), level(right, x - 25, 10), 0.02) << x;
  }
}

TEST(RenderGrey, LevelIsGainTimesRadiancePlusBlack) {
  Scene scene = wall(2, {.albedo = 0.5});
  scene.ambient = 0.8;
  const auto image = render_grey(scene, Viewpoint(scene, {}), kRays, {.gain = 200, .black = 7});
  EXPECT_NEAR(level(image, 3, 3), 7 + 200 * 0.4, 1.0 / (1 << kGreyBits));
  const auto nothing =
      render_grey(Scene{}, Viewpoint(Scene{}, {}), kRays, {.gain = 200, .black = 7});
  EXPECT_EQ(level(nothing, 3, 3), 7);
}

// A black sheet at 1 m ends within a pixel: the pixel's level is the mean by area.
TEST(RenderGrey, EdgesAreSampledByArea) {
  for (int tenth = 0; tenth <= 10; ++tenth) {
    const double edge_u = 60.5 + tenth / 10.0;  // pixel 61 spans 60.5 .. 61.5
    Scene scene = wall(2, {.albedo = 1});
    scene.ambient = 0.5;
    const double edge_x = (edge_u - kLens.cx) / kLens.fx;
    scene.objects.push_back({.shape = Shape::kRectangle,
                             .pose = {.position = {edge_x - 1, 0, 1}},
                             .half = {1, 1, 0},
                             .material = {.albedo = 0}});
    const auto image = render_grey(scene, Viewpoint(scene, {}), kRays, {.gain = 200, .black = 0});
    EXPECT_EQ(level(image, 59, 15), 0);
    EXPECT_EQ(level(image, 63, 15), 100);
    // Six rays across: within half a ray's share.
    EXPECT_NEAR(level(image, 61, 15), 100 * (1 - tenth / 10.0), 100 / 12.0 + 0.01) << tenth;
  }
}

TEST(RenderGrey, HighlightsDoNotLieOnTheSurface) {
  Scene scene = wall(2, {.albedo = 0.1, .gloss = 0.001, .gloss_log2 = 10});
  scene.lights.push_back({.position = {0, 0, -1}, .power = 2});
  const auto brightest = [&](const Pose& pose) {
    const auto image = render_grey(scene, Viewpoint(scene, pose), kRays, {});
    const auto row = image.view().row(15);
    return std::ranges::max_element(row) - row.begin();
  };
  // The light's mirror image stands 3 m behind the wall: 500 * 0.12 / 5 = 12 px, not 30.
  EXPECT_NEAR(static_cast<double>(brightest({}) - brightest(right_of({}))), 12, 1.5);
}

TEST(RenderGrey, PaneShowsWhatIsBehindItAndALittleOfItself) {
  Scene scene = wall(2, kTextured);
  const auto behind = render_grey(scene, Viewpoint(scene, {}), kRays, {.gain = 200, .black = 0});
  add(scene, Shape::kRectangle, {0, 0, 1}, {5, 5, 0}, {.albedo = 0.1, .transmittance = 0.5});
  const auto image = render_grey(scene, Viewpoint(scene, {}), kRays, {.gain = 200, .black = 0});
  for (int x = 0; x < kLens.width; ++x) {
    // 36 rays a pixel in place of 9 of a fine texture.
    EXPECT_NEAR(level(image, x, 15), 0.5 * level(behind, x, 15) + 200 * 0.1 * scene.ambient, 3)
        << x;
  }
}

TEST(RenderObjects, NamesTheObjectAtEachCentre) {
  Scene scene = wall(2);
  add(scene, Shape::kRectangle, {0.5, 0, 1}, {0.5, 1, 0}, {});
  const dataset::Image<int> objects = render_objects(Viewpoint(scene, {}), kRays);
  EXPECT_EQ(objects.view().at(59, 3), 0);
  EXPECT_EQ(objects.view().at(60, 3), 1);
  EXPECT_EQ(render_objects(Viewpoint(Scene{}, {}), kRays).view().at(60, 3), -1);
}

TEST(RenderDepth, IsExactAtPixelCentres) {
  const Scene scene = wall(2);
  for (const float z : render_depth(Viewpoint(scene, {}), kRays).pixels) {
    ASSERT_EQ(z, 2.0F);
  }
  // Turned to the right by yaw a, n = (-sin a, 0, cos a): Z (cos a - x sin a) = 2 for the wall.
  const double half_tan = 0.1;
  const double sine = 2 * half_tan / (1 + half_tan * half_tan);
  const double cosine = (1 - half_tan * half_tan) / (1 + half_tan * half_tan);
  const auto turned_depth = render_depth(Viewpoint(scene, turned(half_tan)), kRays);
  for (int x = 0; x < kLens.width; ++x) {
    const double direction = (x - kLens.cx) / kLens.fx;
    EXPECT_NEAR(turned_depth.view().at(x, 7), 2 / (cosine - direction * sine), 1e-6);
  }
  for (const float z : render_depth(Viewpoint(Scene{}, {}), kRays).pixels) {
    ASSERT_EQ(z, std::numeric_limits<float>::infinity());
  }
}

TEST(RenderVisible, WhatTheNearObjectHidesIsAsWideAsTheDisparityStep) {
  Scene scene = wall(2);
  scene.objects.push_back({.shape = Shape::kRectangle,
                           .pose = {.position = {0.06, 0, 1}},
                           .half = {0.02, 1, 0}});  // columns 79.5 .. 99.5, seen 60 px to the left
  const Viewpoint left(scene, {});
  const Viewpoint right(scene, right_of({}));
  const auto visible = render_visible(left, kRays, right, kLens);
  for (int x = 0; x < kLens.width; ++x) {
    const bool outside = x < 30;            // the wall beyond the right picture's border
    const bool hidden = x >= 50 && x < 70;  // the wall behind the sheet, for the right camera
    const bool sheet = x >= 80 && x < 100;
    EXPECT_EQ(visible.view().at(x, 15), (outside || hidden) && !sheet ? 0 : 255) << x;
  }
}

}  // namespace
}  // namespace stof::test
