#include "tests/dsp/fusion/project/reproject_plain.h"

#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "dsp/fusion/project/reproject.h"
#include "tests/dsp/fusion/project/reproject_rig.h"
#include "tests/support/random.h"

namespace stof::dsp {
namespace {

struct Pair {
  std::string name;
  Calibration rig;
};

Calibration rig_of(const Pinhole& pmd, const Pinhole& left, const RigidTransform& pose) {
  Calibration rig;
  rig.stereo.left = left;
  rig.stereo.baseline_m = 0.2;
  rig.pmd.lens = pmd;
  rig.pmd_to_stereo = pose;
  return rig;
}

Pinhole lens(int width, int height, double focal) {
  return {.width = width,
          .height = height,
          .fx = focal,
          .fy = focal * 1.01,
          .cx = width / 2.0 - 0.7,
          .cy = height / 2.0 + 0.4,
          .k1 = 0};
}

// Turned about the y axis; turns about z are whole quarters.
RigidTransform turned(double degrees, const std::array<double, 3>& translation_m) {
  const double c = std::cos(degrees * 0.017453292519943295);
  const double s = std::sin(degrees * 0.017453292519943295);
  return {{c, 0, s, 0, 1, 0, -s, 0, c}, translation_m};
}

std::vector<Pair> pairs() {
  const RigidTransform quarter{{0, -1, 0, 1, 0, 0, 0, 0, 1}, {0.02, 0.1, 0}};
  const RigidTransform upside_down{{-1, 0, 0, 0, -1, 0, 0, 0, 1}, {0, -0.3, 0.1}};
  return {
      {"footprints of 24 px", chapter_rig(450, 375)},
      {"footprints of 5 px",
       rig_of(lens(176, 144, 159), lens(640, 480, 615), turned(1, {0.06, -0.06, 0}))},
      {"as many pixels", rig_of(lens(96, 80, 110), lens(97, 81, 111), turned(-2, {0.1, 0, 0}))},
      {"finer than the left view",
       rig_of(lens(120, 90, 200), lens(33, 25, 50), turned(3, {0, 0.1, -0.2}))},
      {"on its side", rig_of(lens(64, 48, 60), lens(160, 120, 200), quarter)},
      {"upside down", rig_of(lens(64, 48, 60), lens(160, 120, 200), upside_down)},
      // Rays that run towards the left camera, past it and on behind it.
      {"from the side", rig_of(lens(64, 48, 50), lens(160, 120, 100), turned(-100, {4, 0, 3}))},
      {"face to face", rig_of(lens(64, 48, 50), lens(160, 120, 100), turned(180, {0.1, 0, 6}))},
  };
}

int any_distance(test::Random& random, int x, int y) {
  const int wall = x % 40 < 22 ? 6000 + 20 * y : 14000 - 60 * (x % 50);
  const int kind = random.between(0, 30);
  if (kind == 0) {
    return random.between(1, 65535);
  }
  return kind < 3 ? 0 : std::max(wall + random.between(-200, 200), 1);
}

// Surfaces, holes, edges with long intervals, and readings that no sensor gives.
void fill(Frame& frame, int width, int height, std::uint64_t seed) {
  test::Random random(seed);
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x) {
      const int d = any_distance(random, x, y);
      const int spread = random.between(0, 9) == 0 ? random.between(0, 20000) : d / 50;
      const int low = random.between(0, 60) == 0 ? 0 : std::max(d - spread, 1);
      const int high = random.between(0, 60) == 0 ? 65535 : std::min(d + spread, 65535);
      frame.put(x, y, d == 0 ? 0 : low, d, d == 0 ? 0 : high,
                static_cast<std::uint8_t>(random.between(0, 3) == 0 ? random.between(0, 255) : 0));
    }
  }
}

void expect_equal(const SplattedView& plain, const SplattedView& ours, const std::string& name) {
  for (int y = 0; y < plain.low.height(); ++y) {
    ASSERT_TRUE(std::ranges::equal(plain.nearest.row(y), ours.nearest.row(y))) << name << " " << y;
    ASSERT_TRUE(std::ranges::equal(plain.low.row(y), ours.low.row(y))) << name << " " << y;
    ASSERT_TRUE(std::ranges::equal(plain.high.row(y), ours.high.row(y))) << name << " " << y;
    ASSERT_TRUE(std::ranges::equal(plain.flags.row(y), ours.flags.row(y))) << name << " " << y;
  }
}

struct Seen {
  std::size_t once = 0;
  std::size_t thrice = 0;
  std::size_t twice = 0;  // an end behind the left camera
  bool splatted = false;
};

Seen compare(const Pair& pair, std::uint64_t seed) {
  const int width = pair.rig.stereo.left.width;
  const int height = pair.rig.stereo.left.height;
  Frame frame(pair.rig.pmd.lens.width, pair.rig.pmd.lens.height);
  fill(frame, pair.rig.pmd.lens.width, pair.rig.pmd.lens.height, seed);
  const PlainReprojector plain(pair.rig, frame.maps());
  View expected(width, height, width);
  plain.splat(expected.view());

  Rig part(pair.rig, width, height);
  part.reprojector.locate(frame.maps());
  View whole(width, height, width + 3);
  part.reprojector.splat({0, height}, whole.view());
  expect_equal(expected.view(), whole.view(), pair.name);
  EXPECT_TRUE(whole.padding_untouched()) << pair.name;

  test::Random random(seed);
  View split(width, height, width);
  for (int y = 0; y < height;) {
    const int end = std::min(y + random.between(1, 40), height);
    part.reprojector.splat({y, end}, split.view());
    y = end;
  }
  expect_equal(expected.view(), split.view(), pair.name + ", split");

  Seen seen;
  for (const PlainReading& reading : plain.readings()) {
    seen.once += reading.places.size() == 1 ? 1U : 0U;
    seen.twice += reading.places.size() == 2 ? 1U : 0U;
    seen.thrice += reading.places.size() == 3 ? 1U : 0U;
  }
  for (int y = 0; y < height; ++y) {
    seen.splatted |= std::ranges::any_of(expected.high.view().row(y), [](int v) { return v != 0; });
  }
  return seen;
}

TEST(Reproject, SplatsWhatThePlainOneSplatsForEveryPairOfSensors) {
  Seen all;
  for (const Pair& pair : pairs()) {
    for (std::uint64_t seed = 1; seed <= 3; ++seed) {
      const Seen seen = compare(pair, seed);
      EXPECT_TRUE(seen.splatted) << pair.name;
      all.once += seen.once;
      all.twice += seen.twice;
      all.thrice += seen.thrice;
    }
  }
  EXPECT_GT(all.once, 10000U);
  EXPECT_GT(all.twice, 1000U);
  EXPECT_GT(all.thrice, 1000U);
}

TEST(Reproject, SplatsWhatThePlainOneSplatsInPicturesOfEverySize) {
  for (int size = 1; size <= 40; ++size) {
    const Pinhole pmd = lens(1 + size % 23, 1 + size % 7, 10);
    for (const double focal : {3.0, 30.0, 3000.0}) {  // footprints of a pixel to the whole picture
      const RigidTransform pose = turned(size % 5, {0.1, 0, 0.05});
      const Pair pair{std::to_string(size) + " columns",
                      rig_of(pmd, lens(size, 41 - size, focal), pose)};
      compare(pair, static_cast<std::uint64_t>(size));
    }
  }
}

TEST(Reproject, ForgetsAFrame) {
  const Calibration rig = chapter_rig(64, 48);
  Frame frame(64, 16);
  fill(frame, 64, 16, 1);
  Rig part(rig, 64, 48);
  part.reprojector.locate(frame.maps());
  part.reprojector.forget();
  View out(64, 48, 64);
  part.reprojector.splat({0, 48}, out.view());
  View nothing(64, 48, 64);
  Frame empty(64, 16);
  PlainReprojector(rig, empty.maps()).splat(nothing.view());
  expect_equal(nothing.view(), out.view(), "forgotten");
  part.reprojector.locate(empty.maps());
  EXPECT_TRUE(part.reprojector.footprints().empty());
}

}  // namespace
}  // namespace stof::dsp
