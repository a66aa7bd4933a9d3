#include "dsp/stereo/rectify/rectifier.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

#include "dsp/calib/stereo/rectification.h"
#include "dsp/calib/stereo/remap_table.h"
#include "dsp/stereo/matcher.h"
#include "dsp/stereo/rectify/rectify.h"
#include "tests/dsp/stereo/raw_pair_scene.h"
#include "tests/support/guarded_memory.h"
#include "tests/support/guarded_part.h"

namespace stof::dsp {
namespace {

using raw::Behind;
using raw::Plane;
using raw::raw_pair;

StereoRig completed(const RawPair& pair) {
  StereoRig rig;
  rig.raw = pair;
  EXPECT_STREQ(complete(rig), "");
  return rig;
}

// Both raw pictures of the plane, rectified.
class Scene {
 public:
  Scene(const RawPair& pair, const Plane& plane, double shortest_m)
      : rig(completed(pair)),
        rectified(rectify(pair)),
        width(pair.left.width),
        height(pair.left.height),
        left(width, height, width + 5),
        right(width, height, width + 2),
        owned_([&](Arena& arena) { return Rectifier(rig, arena); }) {
    raw::render(left.view(), shortest_m,
                [&](double u, double v) { return raw::seen_by_left(pair, plane, u, v); });
    raw::render(right.view(), shortest_m,
                [&](double u, double v) { return raw::seen_by_right(pair, plane, u, v); });
  }

  StereoRig rig;
  Rectification rectified;
  int width;
  int height;
  test::GuardedImage<std::uint8_t> left, right;

 private:
  test::GuardedPart<Rectifier> owned_;

 public:
  Rectifier& rectifier = *owned_;
};

double disparity_of(const Scene& scene, double z) {
  return scene.rig.left.fx * scene.rig.baseline_m / z - scene.rig.doff_px;
}

double place_of(const ImageView<const std::uint8_t>& image, double x, int y) {
  const int at = static_cast<int>(std::floor(x));
  return image.at(at, y) + (x - at) * (image.at(at + 1, y) - image.at(at, y));
}

TEST(Rectification, TurnsAreRotationsThatPutTheBaselineOnTheXAxis) {
  const RawPair pair = raw_pair(320, 240, 0.2);
  const Rectification r = rectify(pair);
  EXPECT_NEAR(r.baseline_m, std::sqrt(0.12 * 0.12 + 0.004 * 0.004 + 0.006 * 0.006), 1e-12);
  // A point seen by both: the same Y and Z, X less by the baseline.
  const raw::Vec point{0.3, -0.2, 1.4};
  const raw::Vec left = raw::times(r.left_turn, point);
  const raw::Vec right = raw::times(r.right_turn, raw::to_right_camera(pair, point));
  EXPECT_NEAR(left[0] - right[0], r.baseline_m, 1e-12);
  EXPECT_NEAR(left[1], right[1], 1e-12);
  EXPECT_NEAR(left[2], right[2], 1e-12);
  EXPECT_NEAR(raw::dot(left, left), raw::dot(point, point), 1e-12);
}

TEST(Rectification, OfAParallelPairWithoutDistortionChangesNothing) {
  RawPair pair;
  pair.left = {.width = 64, .height = 48, .fx = 50, .fy = 50, .cx = 31.5, .cy = 23.5};
  pair.right = pair.left;
  pair.left_to_right.translation_m = {-0.1, 0, 0};
  const StereoRig rig = completed(pair);
  EXPECT_DOUBLE_EQ(rig.left.fx, 50);
  EXPECT_NEAR(rig.left.cx, 31.5, 1e-9);
  EXPECT_NEAR(rig.left.cy, 23.5, 1e-9);
  EXPECT_NEAR(rig.baseline_m, 0.1, 1e-12);
  EXPECT_NEAR(rig.doff_px, 0, 1e-9);
}

TEST(Rectification, PutsInfinityAtZeroUnlessThatWouldCostMoreThanAnEighthOfTheWidth) {
  EXPECT_EQ(completed(raw_pair(320, 240, 0.03)).doff_px, 0);
  EXPECT_EQ(completed(raw_pair(320, 240, -0.03)).doff_px, 0);
  // 320 px, f about 290 px: 0.4 rad part the pictures by 119 px, 80 of them are taken out.
  const StereoRig toe_in = completed(raw_pair(320, 240, 0.4));
  EXPECT_NEAR(toe_in.doff_px, 2 * 290 * std::tan(0.2) - 80, 12);
  EXPECT_LT(completed(raw_pair(320, 240, -0.4)).doff_px, -20);
}

TEST(Rectification, CompletingTwiceIsCompletingOnce) {
  StereoRig once = completed(raw_pair(320, 240, 0.4));
  StereoRig twice = once;
  EXPECT_STREQ(complete(twice), "");
  EXPECT_EQ(once.left.cx, twice.left.cx);
  EXPECT_EQ(once.baseline_m, twice.baseline_m);
  EXPECT_EQ(once.doff_px, twice.doff_px);
}

// The tables alone: the point of the plane that the left table sees at (x, y) is what the right
// one sees at (x - d, y), between two of its columns.
TEST(Rectifier, TablesMapOnePointIntoOneRowWithinATenthOfAPixel) {
  for (const double toe_in : {0.03, 0.3}) {
    const RawPair pair = raw_pair(320, 240, toe_in);
    const Rectification r = rectify(pair);
    test::GuardedPart<RemapTable> owned([&](Arena& arena) {
      return RemapTable(SourceMap(pair.right, r.right_turn, r.right), arena);
    });
    const RemapTable& table = *owned;
    const auto place = [&](int x, int y) {
      const Place at = table.place(x, y);
      return std::pair{at.x + at.fraction_x / 128.0, at.y + at.fraction_y / 128.0};
    };
    const auto seen = [&](int x, int y) { return x >= 0 && x < 320 && table.inside(x, y); };
    int compared = 0;
    for (int y = 3; y < 240; y += 7) {
      for (int x = 3; x < 320; x += 7) {
        const Behind behind = raw::behind_rectified(r, Plane{}, x, y);
        const double d = r.left.fx * r.baseline_m / behind.z - (r.right.cx - r.left.cx);
        const int column = static_cast<int>(std::floor(x - d));
        if (!seen(column, y) || !seen(column + 1, y)) {
          continue;
        }
        const double rest = x - d - column;
        const auto [u0, v0] = place(column, y);
        const auto [u1, v1] = place(column + 1, y);
        const auto want = raw::project(pair.right, raw::to_right_camera(pair, behind.point));
        ASSERT_NEAR((1 - rest) * u0 + rest * u1, want[0], 0.1) << x << ", " << y;
        ASSERT_NEAR((1 - rest) * v0 + rest * v1, want[1], 0.1) << x << ", " << y;
        ++compared;
      }
    }
    EXPECT_GT(compared, 900);
  }
}

// Brown's model with OpenCV's coefficients k1 k2 p1 p2 k3, written out once more.
std::array<double, 2> project_brown(const Pinhole& lens, const raw::Vec& p) {
  const double x = p[0] / p[2];
  const double y = p[1] / p[2];
  const double r2 = x * x + y * y;
  const double radial = 1 + lens.k1 * r2 + lens.k2 * std::pow(r2, 2) + lens.k3 * std::pow(r2, 3);
  return {lens.fx * (x * radial + 2 * lens.p1 * x * y + lens.p2 * (r2 + 2 * x * x)) + lens.cx,
          lens.fy * (y * radial + lens.p1 * (r2 + 2 * y * y) + 2 * lens.p2 * x * y) + lens.cy};
}

TEST(Rectifier, TablesTakeTangentialAndSixthOrderDistortion) {
  RawPair pair = raw_pair(320, 240, 0.03);
  pair.left.k3 = -0.08;
  pair.left.p1 = 0.003;
  pair.left.p2 = -0.004;
  const Rectification r = rectify(pair);
  const SourceMap map(pair.left, r.left_turn, r.left);
  test::GuardedPart<RemapTable> owned([&](Arena& arena) { return RemapTable(map, arena); });
  RawPair radial = pair;
  radial.left.k3 = radial.left.p1 = radial.left.p2 = 0;
  int compared = 0;
  double moved = 0;
  for (int y = 0; y < 240; y += 3) {
    for (int x = 0; x < 320; x += 3) {
      const raw::Vec ray{(x - r.left.cx) / r.left.fx, (y - r.left.cy) / r.left.fy, 1};
      const raw::Vec in_camera = raw::times_transposed(r.left_turn, ray);
      const auto want = project_brown(pair.left, in_camera);
      const SourceMap::Place exact = map.unbounded(x, y);
      ASSERT_NEAR(exact.u, want[0], 1e-9);
      ASSERT_NEAR(exact.v, want[1], 1e-9);
      if (!(*owned).inside(x, y)) {
        continue;
      }
      const Place place = (*owned).place(x, y);
      ASSERT_NEAR(place.x + place.fraction_x / 128.0, want[0], 0.51 / 128 + 1.0 / 128);
      ASSERT_NEAR(place.y + place.fraction_y / 128.0, want[1], 0.51 / 128 + 1.0 / 128);
      moved = std::max(moved, std::abs(want[0] - project_brown(radial.left, in_camera)[0]));
      ++compared;
    }
  }
  EXPECT_GT(compared, 7000);
  EXPECT_GT(moved, 1) << "without these coefficients nothing would be tested";
}

TEST(Rectifier, SeesNothingBehindTheFoldOfASixthOrderLens) {
  RawPair pair = raw_pair(160, 120, 0);
  pair.left.k1 = 0;
  pair.left.k2 = 0;
  pair.left.k3 = -8;  // 1 - 56 s^3 = 0 at s = 0.2614
  const Rectification r = rectify(pair);
  const SourceMap map(pair.left, r.left_turn, r.left);
  int behind = 0;
  for (int x = 0; x < 160; ++x) {
    const raw::Vec ray = raw::times_transposed(
        r.left_turn, {(x - r.left.cx) / r.left.fx, -r.left.cy / r.left.fy, 1});
    const double s = (ray[0] * ray[0] + ray[1] * ray[1]) / (ray[2] * ray[2]);
    if (s > std::cbrt(1 / 56.0)) {
      EXPECT_FALSE(map.unbounded(x, 0).inside) << x;
      ++behind;
    }
  }
  EXPECT_GT(behind, 10);
}

// The pictures: a parabola through the differences of the right one moved by a row up, not at all
// and a row down has its minimum where rows correspond.
TEST(Rectifier, RowsOfThePicturesCorrespondWithinATenthOfAPixel) {
  Scene scene(raw_pair(320, 240), Plane{}, 0.03);
  scene.rectifier.rectify(scene.left.view(), scene.right.view(), scene.left.view().rows());
  const auto difference = [&](int down) {
    double sum = 0;
    for (int y = 10; y < 230; ++y) {
      for (int x = 70; x < 310; ++x) {
        const double d =
            disparity_of(scene, raw::behind_rectified(scene.rectified, Plane{}, x, y).z);
        const double e =
            scene.rectifier.left().at(x, y) - place_of(scene.rectifier.right(), x - d, y + down);
        sum += e * e;
      }
    }
    return sum / (220 * 240);
  };
  const double above = difference(-1);
  const double straight = difference(0);
  const double below = difference(1);
  EXPECT_LT(std::sqrt(straight), 3.0);  // grey levels
  EXPECT_GT(std::sqrt(above), 10.0);
  EXPECT_NEAR((above - below) / (above + below - 2 * straight) / 2, 0, 0.1);
}

TEST(Rectifier, MatcherFindsTheDepthOfAPlaneInRawPictures) {
  Scene scene(raw_pair(320, 240), Plane{}, 0.03);
  scene.rectifier.rectify(scene.left.view(), scene.right.view(), scene.left.view().rows());
  const MatchParams params{.disparities = 48,
                           .block_width = 15,
                           .block_height = 15,
                           .left_right_tolerance = 1,
                           .subpixel = Subpixel::kEquiangular};
  test::GuardedPart<Matcher> owned([&](Arena& arena) { return Matcher(params, 320, 240, arena); });
  Matcher& matcher = *owned;
  test::GuardedImage<Disparity> disparity(320, 240, 320);
  matcher.match({.left = scene.rectifier.left(),
                 .right = scene.rectifier.right(),
                 .rectifier = &scene.rectifier},
                disparity.view());
  int found = 0;
  int good = 0;
  double sum = 0;
  for (int y = 0; y < 240; ++y) {
    for (int x = 60; x < 320; ++x) {
      const Disparity d = disparity.view().at(x, y);
      const double want =
          disparity_of(scene, raw::behind_rectified(scene.rectified, Plane{}, x, y).z);
      found += d.valid() ? 1 : 0;
      if (d.valid() && std::abs(d.pixels() - want) <= 0.25) {
        ++good;
        sum += d.pixels() - want;
      }
    }
  }
  EXPECT_GT(found, 260 * 240 * 95 / 100);
  EXPECT_GT(good, found * 97 / 100);
  EXPECT_NEAR(sum / good, 0, 0.02);  // px: neither sees the plane nearer nor further
}

TEST(Rectifier, PixelsThatACameraDidNotSeeHaveNoDisparity) {
  Scene scene(raw_pair(160, 120, 0.35), Plane{}, 0.06);
  scene.rectifier.rectify(scene.left.view(), scene.right.view(), scene.left.view().rows());
  const auto saw = [](const RemapTable& table, int x, int y) {
    return x >= 0 && x < 160 && table.inside(x, y);
  };
  for (const int sixteenths : {0, 8, 7, -8, -9, 300, -300, 16 * 160, -16 * 160, 32767, -32767}) {
    const Disparity all = Disparity::from_raw(static_cast<std::int16_t>(sixteenths));
    test::GuardedImage<Disparity> disparity(160, 120, 163, Disparity::from_raw(99));
    for (int y = 0; y < 120; ++y) {
      std::ranges::fill(disparity.view().row(y), all);
    }
    scene.rectifier.clear_border(disparity.view().rows(), disparity.view());
    EXPECT_TRUE(disparity.padding_is(Disparity::from_raw(99)));
    int cleared = 0;
    for (int y = 0; y < 120; ++y) {
      for (int x = 0; x < 160; ++x) {
        const int match = x - static_cast<int>(std::floor(sixteenths / 16.0 + 0.5));
        const bool want =
            saw(scene.rectifier.left_table(), x, y) && saw(scene.rectifier.right_table(), match, y);
        ASSERT_EQ(disparity.view().at(x, y) == all, want) << sixteenths << " at " << x << ", " << y;
        ASSERT_EQ(disparity.view().at(x, y).valid(), want);
        cleared += want ? 0 : 1;
      }
    }
    EXPECT_GT(cleared, 160 * 120 / 20) << sixteenths;
  }
}

TEST(Rectifier, DoesNotDependOnTheSplitOfRows) {
  Scene scene(raw_pair(67, 31, 0.2), Plane{}, 0.1);
  const auto pictures = [&] {
    std::vector<std::uint8_t> all;
    for (const auto& image : {scene.rectifier.left(), scene.rectifier.right()}) {
      for (int y = 0; y < image.height(); ++y) {
        all.insert(all.end(), image.row(y).begin(), image.row(y).end());
      }
    }
    return all;
  };
  scene.rectifier.rectify(scene.left.view(), scene.right.view(), {0, 31});
  const std::vector<std::uint8_t> whole = pictures();
  for (int step = 1; step < 31; step += 7) {
    test::GuardedImage<std::uint8_t> grey(67, 31, 67, 1);
    scene.rectifier.rectify(grey.view(), grey.view(), {0, 31});
    for (int y = 0; y < 31; y += step) {
      scene.rectifier.rectify(scene.left.view(), scene.right.view(), {y, std::min(y + step, 31)});
    }
    EXPECT_EQ(pictures(), whole) << step;
  }
}

TEST(Rectifier, TakesTheSmallestPictures) {
  for (const auto& [w, h] : {std::pair{2, 2}, {3, 40}, {40, 2}}) {
    Scene scene(raw_pair(w, h, 0), Plane{}, 1);
    scene.rectifier.rectify(scene.left.view(), scene.right.view(), {0, h});
    EXPECT_EQ(scene.rectifier.left().width(), w);
    EXPECT_EQ(scene.rectifier.right().height(), h);
  }
}

TEST(RawPair, WhatCannotBeRectifiedIsNamed) {
  const auto wrong = [](const auto& change) {
    StereoRig rig;
    rig.raw = raw_pair(64, 48);
    change(*rig.raw);
    return std::string(complete(rig));
  };
  EXPECT_EQ(wrong([](RawPair&) {}), "");
  EXPECT_NE(wrong([](RawPair& p) { p.right.width = 63; }), "");
  EXPECT_NE(wrong([](RawPair& p) { p.left.width = p.right.width = 1; }), "");
  EXPECT_NE(wrong([](RawPair& p) { p.right.fx = 0; }), "");
  EXPECT_NE(wrong([](RawPair& p) { p.left.k1 = std::nan(""); }), "");
  EXPECT_NE(wrong([](RawPair& p) { p.left_to_right.rotation[4] = -1; }), "");
  EXPECT_NE(wrong([](RawPair& p) { p.left_to_right.rotation = raw::turned(0, 1.2, 0); }), "");
  EXPECT_NE(wrong([](RawPair& p) { p.left_to_right.rotation = {1, 0, 0, 0, -1, 0, 0, 0, 1}; }), "");
  EXPECT_NE(wrong([](RawPair& p) { p.left_to_right.translation_m = {}; }), "");
  EXPECT_NE(wrong([](RawPair& p) { p.left_to_right.translation_m = {0.1, 0, 0}; }), "");
  EXPECT_NE(wrong([](RawPair& p) { p.left_to_right.translation_m = {-0.1, 0.2, 0}; }), "");
  EXPECT_NE(wrong([](RawPair& p) { p.left_to_right.translation_m[1] = std::nan(""); }), "");
  EXPECT_NE(wrong([](RawPair& p) { p.left.k1 = p.right.k1 = -40; }), "");  // folds at once
}

}  // namespace
}  // namespace stof::dsp
