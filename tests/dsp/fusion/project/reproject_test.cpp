#include "dsp/fusion/project/reproject.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <vector>

#include <gtest/gtest.h>

#include "dsp/calib/pmd/ray_table.h"
#include "dsp/pmd/interval/average_pairs.h"
#include "dsp/pmd/interval/fill_intervals.h"
#include "tests/dsp/fusion/project/reproject_rig.h"
#include "tests/support/random.h"

namespace stof::dsp {
namespace {

// The same geometry in double precision, straight from the specification.
struct Exact {
  double u, v, z;
};
Exact exact_place(const Calibration& rig, int x, int y, double distance) {
  const std::array<double, 3> ray = unit_ray(rig.pmd.lens, x, y);
  std::array<double, 3> p{};
  for (std::size_t k = 0; k < 3; ++k) {
    p[k] = 4000 * rig.pmd_to_stereo.translation_m[k];
    for (std::size_t j = 0; j < 3; ++j) {
      p[k] += rig.pmd_to_stereo.rotation[3 * k + j] * ray[j] * distance;
    }
  }
  const Pinhole& left = rig.stereo.left;
  return {left.fx * p[0] / p[2] + left.cx, left.fy * p[1] / p[2] + left.cy, p[2]};
}

struct Box {
  double left, right, top, bottom, z, low, high;
};
void add_box(std::vector<Box>& boxes, const Exact& at, double half_x, double half_y, double z,
             double low, double high) {
  boxes.push_back({at.u - half_x, at.u + half_x, at.v - half_y, at.v + half_y, z, low, high});
}
std::vector<Box> exact_boxes(const Calibration& rig, Frame& frame) {
  std::vector<Box> boxes;
  for (int y = 0; y < rig.pmd.lens.height; ++y) {
    for (int x = 0; x < rig.pmd.lens.width; ++x) {
      const double d = frame.distance.view().at(x, y);
      if (d == 0) {
        continue;
      }
      const Exact low = exact_place(rig, x, y, frame.low.view().at(x, y));
      const Exact centre = exact_place(rig, x, y, d);
      const Exact high = exact_place(rig, x, y, frame.high.view().at(x, y));
      const double ratio = d * unit_ray(rig.pmd.lens, x, y)[2] / centre.z;
      const double half_x = rig.stereo.left.fx / rig.pmd.lens.fx * ratio / 2 + 0.6;
      const double half_y = rig.stereo.left.fy / rig.pmd.lens.fy * ratio / 2 + 0.6;
      add_box(boxes, centre, half_x, half_y, centre.z, low.z, high.z);
      if (std::abs(low.u - high.u) > half_x || std::abs(low.v - high.v) > half_y) {
        add_box(boxes, low, half_x, half_y, centre.z, low.z, high.z);
        add_box(boxes, high, half_x, half_y, centre.z, low.z, high.z);
      }
    }
  }
  return boxes;
}

// What the specification says about one pixel of the left view. `sure` is false where a border of a
// footprint or of the 2 percent rule is too close to call with 1/16 px and 1/4 mm.
struct Verdict {
  double low = 0;
  double high = 0;
  bool splatted = false;
  bool sure = true;
};
constexpr double kNear = 0.15;

// Those that say something about row y: all would take a minute.
std::vector<Box> boxes_at_row(const std::vector<Box>& boxes, int y) {
  std::vector<Box> at_row;
  std::ranges::copy_if(boxes, std::back_inserter(at_row), [&](const Box& box) {
    return box.top - kNear <= y && y <= box.bottom + kNear;
  });
  return at_row;
}

Verdict exact_verdict(const std::vector<Box>& boxes, int x, int y) {
  Verdict verdict;
  std::vector<const Box*> over;
  double nearest = 1e9;
  for (const Box& box : boxes) {
    const double inside = std::min({x - box.left, box.right - x, y - box.top, box.bottom - y});
    verdict.sure = verdict.sure && std::abs(inside) > kNear;
    if (inside >= 0) {
      over.push_back(&box);
      nearest = std::min(nearest, box.z);
    }
  }
  verdict.splatted = !over.empty();
  verdict.low = 1e9;
  for (const Box* box : over) {
    verdict.sure = verdict.sure && std::abs(box->z - 1.02 * nearest) > 4;
    if (box->z <= 1.02 * nearest) {
      verdict.low = std::min(verdict.low, box->low);
      verdict.high = std::max(verdict.high, box->high);
    }
  }
  return verdict;
}

void fill_with_surfaces(Frame& frame, std::uint64_t seed) {
  test::Random random(seed);
  for (int y = 0; y < 16; ++y) {
    for (int x = 0; x < 64; ++x) {
      const int base = x < 30 ? 6000 + 20 * y : 14000 - 60 * x;
      const int d = base + random.between(-150, 150);
      const int spread = random.between(0, 5) == 0 ? 3000 : 100;  // a wide one is splatted thrice
      if (random.between(0, 7) != 0) {
        frame.put(x, y, d - spread, d, d + spread,
                  x % 5 == 0 ? std::uint8_t{kPmdEdge} : std::uint8_t{0});
      }
    }
  }
}

TEST(Reproject, EqualsTheGeometryInDoublePrecision) {
  constexpr int kWidth = 320;
  constexpr int kHeight = 240;
  const Calibration rig = chapter_rig(kWidth, kHeight);
  Frame frame(64, 16);
  fill_with_surfaces(frame, 1);
  Rig part(rig, kWidth, kHeight);
  part.reprojector.locate(frame.maps());
  View out(kWidth, kHeight, kWidth + 5);
  part.reprojector.splat({0, kHeight}, out.view());
  const std::vector<Box> boxes = exact_boxes(rig, frame);
  int judged = 0;
  int splatted = 0;
  for (int y = 0; y < kHeight; ++y) {
    const std::vector<Box> at_row = boxes_at_row(boxes, y);
    for (int x = 0; x < kWidth; ++x) {
      const Verdict exact = exact_verdict(at_row, x, y);
      if (!exact.sure) {
        continue;
      }
      ++judged;
      ASSERT_EQ(out.high.view().at(x, y) != 0, exact.splatted) << x << "," << y;
      if (exact.splatted) {
        ++splatted;
        ASSERT_NEAR(out.low.view().at(x, y), exact.low, 2) << x << "," << y;
        ASSERT_NEAR(out.high.view().at(x, y), exact.high, 2) << x << "," << y;
      } else {
        ASSERT_EQ(out.low.view().at(x, y), kNoSplat);
      }
    }
  }
  EXPECT_GT(judged, kWidth * kHeight / 2);
  EXPECT_GT(splatted, kWidth * kHeight / 4);
  EXPECT_TRUE(out.padding_untouched());
}

// Readings of a noisy wall lie where their surface does, each in its own interval.
TEST(Reproject, AReadingLiesWhereItsSurfaceDoes) {
  constexpr int kWidth = 64;
  constexpr int kHeight = 16;
  test::Random random(3);
  std::vector<QuarterMm> memory(2 * (kWidth + 2) * kHeight);
  const ImageView<QuarterMm> distance(memory.data() + 1, kWidth, kHeight, kWidth + 2);
  const ImageView<QuarterMm> sigma(memory.data() + 1 + memory.size() / 2, kWidth, kHeight,
                                   kWidth + 2);
  Frame frame(kWidth, kHeight);
  for (int y = 0; y < kHeight; ++y) {
    for (int x = 0; x < kWidth; ++x) {
      const int d = 8000 + random.between(-200, 200);
      frame.put(x, y, d - 700, d, d + 700);
      distance.at(x, y) = static_cast<QuarterMm>(d);
      sigma.at(x, y) = 150;
    }
  }
  PmdMaps maps = frame.maps();
  maps.distance = distance;
  maps.sigma = sigma;
  std::vector<QuarterMm> unused(kWidth);
  for (int y = 1; y < kHeight - 1; ++y) {
    best::average_pairs(located_rows(maps, y), maps.slope_q16, frame.distance.view().row(y),
                        unused);
  }
  Rig averaged(chapter_rig(640, 480), 640, 480);
  averaged.reprojector.locate(maps);
  Rig plain(chapter_rig(640, 480), 640, 480);
  plain.reprojector.locate(frame.maps());  // without sigmas
  const auto found = averaged.reprojector.footprints();
  const auto wanted = plain.reprojector.footprints();
  ASSERT_EQ(found.size(), wanted.size());
  ASSERT_GT(found.size(), 100U);
  bool moved = false;
  for (std::size_t i = 0; i < found.size(); ++i) {
    EXPECT_EQ(found[i].depth, wanted[i].depth) << i;
    EXPECT_EQ(found[i].x_begin, wanted[i].x_begin) << i;
    EXPECT_EQ(found[i].y_begin, wanted[i].y_begin) << i;
    EXPECT_EQ(found[i].value.low, wanted[i].value.low) << i;
    EXPECT_EQ(found[i].value.high, wanted[i].value.high) << i;
    moved = moved || 2 * found[i].depth != found[i].value.low + found[i].value.high;
  }
  EXPECT_TRUE(moved);
}

TEST(Reproject, DoesNotDependOnHowRowsAreSplit) {
  constexpr int kWidth = 160;
  constexpr int kHeight = 120;
  const Calibration rig = chapter_rig(kWidth, kHeight);
  Frame frame(64, 16);
  fill_with_surfaces(frame, 2);
  Rig part(rig, kWidth, kHeight);
  part.reprojector.locate(frame.maps());
  View whole(kWidth, kHeight, kWidth);
  part.reprojector.splat({0, kHeight}, whole.view());
  for (const int stripe : {1, 7, 32, 119}) {
    View split(kWidth, kHeight, kWidth + 3);
    for (int y = 0; y < kHeight; y += stripe) {
      part.reprojector.splat({y, std::min(y + stripe, kHeight)}, split.view());
    }
    for (int y = 0; y < kHeight; ++y) {
      ASSERT_TRUE(std::ranges::equal(whole.low.view().row(y), split.low.view().row(y))) << stripe;
      ASSERT_TRUE(std::ranges::equal(whole.high.view().row(y), split.high.view().row(y)));
      ASSERT_TRUE(std::ranges::equal(whole.flags.view().row(y), split.flags.view().row(y)));
      ASSERT_TRUE(std::ranges::equal(whole.nearest.view().row(y), split.nearest.view().row(y)));
    }
  }
}

TEST(Reproject, SplatsAFootprintOfThirtyThreePixelsStraightAhead) {
  Calibration rig = chapter_rig(640, 480);
  rig.stereo.left.fx = rig.stereo.left.fy = 1483;  // 640 columns, 24.35 degrees
  rig.pmd.lens.k1 = 0;
  rig.pmd.lens.cx = 32;
  rig.pmd_to_stereo = {};
  Frame frame(64, 16);
  frame.put(32, 10, 7900, 8000, 8100, kPmdEdge);
  Rig part(rig, 640, 480);
  part.reprojector.locate(frame.maps());
  ASSERT_EQ(part.reprojector.footprints().size(), 1U);
  const Footprint& f = part.reprojector.footprints()[0];
  // Half-size 1483 / 45.279 / 2 + 0.6 = 16.98 px around (320, 240).
  EXPECT_EQ(f.x_begin, 304);
  EXPECT_EQ(f.x_end, 337);
  EXPECT_EQ(f.y_begin, 224);
  EXPECT_EQ(f.y_end, 257);
  EXPECT_EQ(f.depth, 8000);
  EXPECT_EQ(f.value.low, 7900);
  EXPECT_EQ(f.value.high, 8100);
  EXPECT_EQ(f.value.flags, kPmdEdge);
}

TEST(Reproject, NearerThanTwoPercentHidesWhateverTheOrder) {
  Calibration rig = chapter_rig(200, 150);
  rig.pmd_to_stereo = {};
  for (const bool swapped : {false, true}) {
    Frame frame(64, 16);
    // Neighbours overlap by their margins; 8000 is 25 percent nearer than 10000.
    frame.put(32, 10, 7900, swapped ? 10000 : 8000, 8100);
    frame.put(33, 10, 9900, swapped ? 8000 : 10000, 10100);
    Rig part(rig, 200, 150);
    part.reprojector.locate(frame.maps());
    ASSERT_EQ(part.reprojector.footprints().size(), 2U);
    const Footprint& a = part.reprojector.footprints()[0];
    const Footprint& b = part.reprojector.footprints()[1];
    ASSERT_LT(b.x_begin, a.x_end);
    View out(200, 150, 200);
    part.reprojector.splat({0, 150}, out.view());
    const Footprint& near = swapped ? b : a;
    EXPECT_EQ(out.low.view().at(b.x_begin, a.y_begin), near.value.low);
    EXPECT_EQ(out.high.view().at(b.x_begin, a.y_begin), near.value.high);
  }
}

TEST(Reproject, LeavesOutWhatLiesBehindTheCameraOrOutsideTheImage) {
  Calibration rig = chapter_rig(64, 48);
  Frame frame(64, 16);
  for (int y = 0; y < 16; ++y) {
    for (int x = 0; x < 64; ++x) {
      frame.put(x, y, 7900, 8000, 8100);
    }
  }
  rig.pmd_to_stereo = {{-1, 0, 0, 0, 1, 0, 0, 0, -1}, {0, 0, 0}};  // looks the other way
  Rig behind(rig, 64, 48);
  behind.reprojector.locate(frame.maps());
  EXPECT_TRUE(behind.reprojector.footprints().empty());
  rig.pmd_to_stereo = {{1, 0, 0, 0, 1, 0, 0, 0, 1}, {90, 0, 0}};  // 90 m to the side
  Rig aside(rig, 64, 48);
  aside.reprojector.locate(frame.maps());
  EXPECT_TRUE(aside.reprojector.footprints().empty());
}

TEST(Reproject, SurvivesExtremeRigsAndReadings) {
  test::Random random(4);
  for (int round = 0; round < 60; ++round) {
    Calibration rig = chapter_rig(round % 3 == 0 ? 1 : 40, round % 3 == 1 ? 1 : 30);
    const int w = rig.stereo.left.width;
    const int h = rig.stereo.left.height;
    rig.pmd.lens.k1 = random.between(-20, 20) / 10.0;
    rig.stereo.left.fx = random.between(1, 4000);
    for (double& t : rig.pmd_to_stereo.translation_m) {
      t = random.between(-9999, 9999) / (round % 2 == 0 ? 100.0 : 100000.0);
    }
    Frame frame(64, 16);
    for (int i = 0; i < 500; ++i) {
      const int d = random.between(1, 65535);
      frame.put(random.between(0, 63), random.between(0, 15), random.between(1, d), d,
                random.between(d, 65535), static_cast<std::uint8_t>(random.next()));
    }
    Rig part(rig, w, h);
    part.reprojector.locate(frame.maps());
    View out(w, h, w);
    part.reprojector.splat({0, h}, out.view());
    for (int y = 0; y < h; ++y) {
      for (int x = 0; x < w; ++x) {
        if (out.high.view().at(x, y) != 0) {
          ASSERT_LE(out.low.view().at(x, y), out.high.view().at(x, y));
          ASSERT_GT(out.low.view().at(x, y), 0);
        }
      }
    }
  }
}

}  // namespace
}  // namespace stof::dsp
