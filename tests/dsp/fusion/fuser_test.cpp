#include "dsp/fusion/fuser.h"

#include <algorithm>
#include <cmath>
#include <new>
#include <vector>

#include <gtest/gtest.h>

#include "dsp/base/thread_team.h"
#include "posix/worker_threads.h"
#include "tests/support/guarded_memory.h"
#include "tests/support/guarded_part.h"

namespace stof::dsp {
namespace {

// Both cameras in one place; f b = 100 px m, so 50 px are 2 m; PMD pixels are 10 px wide.
Calibration simple_rig(int width, int height, int pmd_width, int pmd_height) {
  Calibration rig;
  rig.stereo.left = {.width = width,
                     .height = height,
                     .fx = 400,
                     .fy = 400,
                     .cx = width / 2.0,
                     .cy = height / 2.0};
  rig.stereo.baseline_m = 0.25;
  rig.pmd.lens = {.width = pmd_width,
                  .height = pmd_height,
                  .fx = 40,
                  .fy = 40,
                  .cx = pmd_width / 2.0,
                  .cy = pmd_height / 2.0};
  return rig;
}

class Rig {
 public:
  Rig(const Calibration& rig, int w, int h, int disparities = 64, int threads = 1)
      : owned_([&](Arena& arena) { return Fuser(rig, {}, 0, disparities, w, h, arena, threads); }),
        depth(w, h, w + 3, 9),
        width(w, h, w + 2, 9),
        source(w, h, w + 1, Source::kConflict),
        disparity(w, h, w + 1) {}

  DepthMap out() { return {depth.view(), width.view(), source.view()}; }
  bool padding_untouched() {
    return depth.padding_is(9) && width.padding_is(9) && source.padding_is(Source::kConflict);
  }

 private:
  test::GuardedPart<Fuser> owned_;

 public:
  test::GuardedImage<QuarterMm> depth;
  test::GuardedImage<QuarterMm> width;
  test::GuardedImage<Source> source;
  test::GuardedImage<Disparity> disparity;
  Fuser& fuser = *owned_;
};

template <typename T>
void fill(const ImageView<T>& image, T value) {
  for (int y = 0; y < image.height(); ++y) {
    std::ranges::fill(image.row(y), value);
  }
}

// A PMD frame that sees one flat thing at one distance along every ray.
struct Sphere {
  Sphere(int w, int h, QuarterMm distance, QuarterMm half, std::uint8_t flag = 0)
      : d(w, h, w), lo(w, h, w), hi(w, h, w), f(w, h, w, flag) {
    fill(d.view(), distance);
    fill(lo.view(), static_cast<QuarterMm>(distance - half));
    fill(hi.view(), static_cast<QuarterMm>(distance + half));
    maps.distance = d.view();
    maps.low = lo.view();
    maps.high = hi.view();
    maps.flags = f.view();
  }
  test::GuardedImage<QuarterMm> d, lo, hi;
  test::GuardedImage<std::uint8_t> f;
  PmdMaps maps;
};

struct At {
  int depth;
  int width;
  Source source;
  friend bool operator==(const At&, const At&) = default;
};
At at(Rig& rig, int x, int y) {
  return {rig.depth.view().at(x, y), rig.width.view().at(x, y), rig.source.view().at(x, y)};
}

TEST(Fuser, NarrowsAPlaneAtTwoMetresToWhatBothAllow) {
  Rig rig(simple_rig(80, 40, 20, 10), 80, 40);
  fill(rig.disparity.view(), Disparity::from_pixels(50));  // 7843 .. 8164
  Sphere pmd(20, 10, 8200, 200);                           // 8000 .. 8400 straight ahead
  rig.fuser.fuse({.disparity = rig.disparity.view()}, &pmd.maps, rig.out());
  const At centre = at(rig, 40, 20);
  EXPECT_EQ(centre.source, Source::kBoth);
  EXPECT_NEAR(centre.depth, 8082, 8);  // footprints of neighbours: a little nearer
  EXPECT_NEAR(centre.width, 164, 16);
  EXPECT_TRUE(rig.padding_untouched());
}

// 1.5 m/s for 6 ms are 9 mm, to either side; who stands still has not moved.
TEST(Fuser, ALaterPmdExposureOfWhatMovesHasALongerInterval) {
  Rig rig(simple_rig(80, 40, 20, 10), 80, 40);
  fill(rig.disparity.view(), Disparity::none());
  const auto width_at = [&](bool moved, std::int32_t lag_us) {
    Sphere pmd(20, 10, 8200, 200);
    pmd.maps.moved = moved;
    const StereoMaps stereo{.disparity = rig.disparity.view()};
    rig.fuser.prepare(&pmd.maps, lag_us);
    rig.fuser.fuse_rows(stereo, {0, 40}, 0, rig.out());
    return at(rig, 40, 20).width;
  };
  const int still = width_at(false, 0);
  EXPECT_GE(still, 400);
  EXPECT_EQ(width_at(false, 6000), still);
  EXPECT_EQ(width_at(true, 0), still);
  EXPECT_EQ(width_at(true, 6000), still + 2 * 36);
  EXPECT_EQ(width_at(true, -6000), still + 2 * 36);
  EXPECT_EQ(width_at(true, 1), still + 2);
}

TEST(Fuser, GivesStereoAloneItsOwnInterval) {
  Rig rig(simple_rig(33, 5, 0, 0), 33, 5);
  fill(rig.disparity.view(), Disparity::from_pixels(50));
  rig.disparity.view().at(3, 3) = Disparity::none();
  rig.fuser.fuse({.disparity = rig.disparity.view()}, nullptr, rig.out());
  EXPECT_EQ(at(rig, 0, 0), (At{8003, 322, Source::kStereo}));
  EXPECT_EQ(at(rig, 3, 3), (At{0, 0, Source::kNone}));
}

TEST(Fuser, TakesTheIntervalFromBothColumnsWhereAxesConverge) {
  // Axes that meet at 2 m, f = 400 px: disparity 0 in the middle is 2 m, other columns are nearer.
  Calibration rig = simple_rig(81, 3, 0, 0);
  const double half = std::atan(0.125 / 2);
  rig.stereo.converging = Converging{.alpha_rad = half,
                                     .beta_rad = -half,
                                     .f1_m = 0.004,
                                     .f2_m = 0.004,
                                     .pixel_m = 1e-5,
                                     .cx_left = 40,
                                     .cx_right = 40};
  ASSERT_STREQ(complete(rig.stereo), "");
  Rig fusion(rig, 81, 3);
  fill(fusion.disparity.view(), Disparity::from_pixels(0));
  fusion.disparity.view().at(7, 1) = Disparity::none();
  fusion.fuser.fuse({.disparity = fusion.disparity.view()}, nullptr, fusion.out());
  const At middle = at(fusion, 40, 1);
  EXPECT_EQ(middle.source, Source::kStereo);
  EXPECT_NEAR(middle.depth, 8000, 8);
  EXPECT_NEAR(middle.width, 320, 4);  // one pixel of 50 either way
  EXPECT_LT(at(fusion, 0, 1).depth, middle.depth - 20);
  EXPECT_LT(at(fusion, 80, 1).depth, middle.depth - 20);
  EXPECT_EQ(at(fusion, 7, 1), (At{0, 0, Source::kNone}));
  EXPECT_TRUE(fusion.padding_untouched());
}

TEST(Fuser, GivesThePmdAloneItsOwnIntervalAndForgetsItInTheNextFrame) {
  Rig rig(simple_rig(80, 40, 20, 10), 80, 40);
  Sphere pmd(20, 10, 8200, 200);
  rig.fuser.fuse({}, &pmd.maps, rig.out());
  const At centre = at(rig, 40, 20);
  EXPECT_EQ(centre.source, Source::kPmd);
  EXPECT_NEAR(centre.depth, 8200, 8);
  EXPECT_NEAR(centre.width, 400, 16);
  rig.fuser.fuse({}, nullptr, rig.out());
  EXPECT_EQ(at(rig, 40, 20), (At{0, 0, Source::kNone}));
}

TEST(Fuser, WeighsAConflictByWhatSupportsEachSensor) {
  Rig rig(simple_rig(80, 40, 20, 10), 80, 40);
  fill(rig.disparity.view(), Disparity::from_pixels(50));
  test::GuardedImage<std::uint8_t> ratio(80, 40, 80, 250);
  const StereoMaps rivals{.disparity = rig.disparity.view(), .ratio = ratio.view()};
  Sphere flat(20, 10, 12000, 200);
  Sphere edge(20, 10, 12000, 200, kPmdEdge);
  rig.fuser.fuse(rivals, &edge.maps, rig.out());
  EXPECT_EQ(at(rig, 40, 20), (At{0, 0, Source::kConflict}));
  rig.fuser.fuse(rivals, &flat.maps, rig.out());
  EXPECT_EQ(at(rig, 40, 20).source, Source::kResolved);
  EXPECT_NEAR(at(rig, 40, 20).depth, 12000, 12);
  fill(ratio.view(), std::uint8_t{20});
  rig.fuser.fuse(rivals, &flat.maps, rig.out());
  EXPECT_EQ(at(rig, 40, 20), (At{0, 0, Source::kConflict}));
  // A sure match against a mixed reading: it may lie behind what was read, not before it.
  rig.fuser.fuse(rivals, &edge.maps, rig.out());
  EXPECT_EQ(at(rig, 40, 20), (At{0, 0, Source::kConflict}));
  Sphere before(20, 10, 6500, 200, kPmdEdge);
  rig.fuser.fuse(rivals, &before.maps, rig.out());
  EXPECT_EQ(at(rig, 40, 20).source, Source::kResolved);
  EXPECT_NEAR(at(rig, 40, 20).depth, 8000, 8);
}

TEST(Fuser, MatchesWithRivalsGetWiderIntervals) {
  Rig rig(simple_rig(64, 3, 0, 0), 64, 3);
  fill(rig.disparity.view(), Disparity::from_pixels(50));
  test::GuardedImage<std::uint8_t> ratio(64, 3, 64);
  int before = 0;
  for (int step = 0; step < 16; ++step) {
    fill(ratio.view(), static_cast<std::uint8_t>(16 * step));
    rig.fuser.fuse({.disparity = rig.disparity.view(), .ratio = ratio.view()}, nullptr, rig.out());
    const At pixel = at(rig, 9, 1);
    EXPECT_GE(pixel.width, before) << step;
    EXPECT_NEAR(pixel.depth, 8000, 150) << step;
    before = pixel.width;
  }
  EXPECT_GT(before, 1600);  // an eighth of 8000 to either side at most
  EXPECT_LT(before, 2100);
}

TEST(Fuser, AWeakMatchCountsWhereThePmdAgreesAndNowhereElse) {
  Rig rig(simple_rig(80, 40, 20, 10), 80, 40);
  fill(rig.disparity.view(), Disparity::none());
  test::GuardedImage<Disparity> weak(80, 40, 80);
  fill(weak.view(), Disparity::from_pixels(50));
  const StereoMaps stereo{.disparity = rig.disparity.view(), .weak = weak.view()};
  rig.fuser.fuse(stereo, nullptr, rig.out());
  EXPECT_EQ(at(rig, 40, 20), (At{0, 0, Source::kNone}));
  Sphere near(20, 10, 8300, 1000);
  rig.fuser.fuse(stereo, &near.maps, rig.out());
  EXPECT_EQ(at(rig, 40, 20).source, Source::kBoth);
  const At weakly = at(rig, 40, 20);
  EXPECT_NEAR(weakly.depth, 8000, 100);  // the match's: the PMD alone 8300
  EXPECT_LE(weakly.depth - weakly.width / 2, 7300);
  EXPECT_GE(weakly.depth + weakly.width / 2, 9300);
  Sphere far(20, 10, 12000, 200);
  rig.fuser.fuse(stereo, &far.maps, rig.out());
  EXPECT_EQ(at(rig, 40, 20).source, Source::kPmd);
}

TEST(Fuser, ConvertsRadialDistanceToDepth) {
  Calibration calibration = simple_rig(320, 40, 40, 10);
  Rig rig(calibration, 320, 40);
  Sphere pmd(40, 10, 10000, 4);
  rig.fuser.fuse({}, &pmd.maps, rig.out());
  // PMD pixel 10 from the middle of 20: tan = 10 / 40, column 160 - 100.
  EXPECT_NEAR(at(rig, 60, 20).depth, 10000 / std::sqrt(1 + 0.0625), 8);
}

void fill_steps(const ImageView<Disparity>& disparity) {
  for (int y = 0; y < disparity.height(); ++y) {
    for (int x = 0; x < disparity.width(); ++x) {
      const int raw = (x * 7 + y * 13) % 5 == 0 ? 0 : 16 * (40 + (x / 9 + y / 7) % 20);
      disparity.at(x, y) =
          raw == 0 ? Disparity::none() : Disparity::from_raw(static_cast<std::int16_t>(raw));
    }
  }
}

bool same(Rig& a, Rig& b) {
  bool equal = true;
  for (int y = 0; y < a.depth.view().height(); ++y) {
    equal = equal && std::ranges::equal(a.depth.view().row(y), b.depth.view().row(y)) &&
            std::ranges::equal(a.width.view().row(y), b.width.view().row(y)) &&
            std::ranges::equal(a.source.view().row(y), b.source.view().row(y));
  }
  return equal;
}

TEST(Fuser, AnySplitOfRowsGivesTheSame) {
  constexpr int kHeight = 150;  // more than two stripes
  Rig whole(simple_rig(80, kHeight, 20, 40), 80, kHeight);
  Rig split(simple_rig(80, kHeight, 20, 40), 80, kHeight);
  fill_steps(whole.disparity.view());
  const StereoMaps stereo{.disparity = whole.disparity.view()};
  Sphere pmd(20, 40, 8300, 1000, kPmdEdge);
  whole.fuser.fuse(stereo, &pmd.maps, whole.out());
  for (const int step : {1, 7, 64, 149}) {
    fill(split.depth.view(), QuarterMm{3});
    split.fuser.prepare(&pmd.maps);
    for (int end = kHeight; end > 0; end -= step) {
      split.fuser.fuse_rows(stereo, {std::max(end - step, 0), end}, 0, split.out());
    }
    ASSERT_TRUE(same(whole, split)) << step;
  }
}

TEST(Fuser, ThreadsAtOnceGiveTheSame) {
  posix::WorkerThreads workers({.threads = 4});
  for (const auto& [w, h] : {std::pair{1, 1}, {1, 99}, {61, 1}, {33, 17}, {79, 133}}) {
    const Calibration calibration = simple_rig(w, h, 20, 40);
    Rig whole(calibration, w, h);
    fill_steps(whole.disparity.view());
    const StereoMaps stereo{.disparity = whole.disparity.view()};
    Sphere pmd(20, 40, 8300, 1000, kPmdEdge);
    whole.fuser.fuse(stereo, &pmd.maps, whole.out());
    for (int threads = 1; threads <= 4; ++threads) {
      Rig crewed(calibration, w, h, 64, threads);
      for (int frame = 0; frame < 20; ++frame) {
        fill(crewed.depth.view(), QuarterMm{3});
        crewed.fuser.prepare(&pmd.maps);
        ThreadTeam(workers, threads).run_rows({0, h}, 3, [&](Rows rows, int thread) noexcept {
          crewed.fuser.fuse_rows(stereo, rows, thread, crewed.out());
        });
        ASSERT_TRUE(same(whole, crewed)) << w << "x" << h << ", " << threads << " threads";
      }
    }
  }
}

TEST(Fuser, WritesEveryPixelOfAnySizeFromOneByOne) {
  for (const auto& [w, h] : {std::pair{1, 1}, {1, 7}, {7, 1}, {8, 3}, {17, 2}}) {
    for (const auto& [pw, ph] : {std::pair{0, 0}, {1, 1}, {9, 2}}) {
      Rig rig(simple_rig(w, h, pw, ph), w, h, 1);
      fill(rig.disparity.view(), Disparity::none());
      Sphere pmd(pw, ph, 8000, 100);
      rig.fuser.fuse({.disparity = rig.disparity.view()}, pw == 0 ? nullptr : &pmd.maps, rig.out());
      for (int y = 0; y < h; ++y) {
        for (int x = 0; x < w; ++x) {
          const At pixel = at(rig, x, y);
          ASSERT_TRUE(pixel.source == Source::kNone || pixel.source == Source::kPmd);
          ASSERT_EQ(pixel.source == Source::kNone, pixel.depth == 0);
        }
      }
      EXPECT_TRUE(rig.padding_untouched()) << w << "x" << h;
    }
  }
}

}  // namespace
}  // namespace stof::dsp
