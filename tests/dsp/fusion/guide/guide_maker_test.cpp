#include "dsp/fusion/guide/guide_maker.h"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "dataset/dataset.h"
#include "tests/dsp/fusion/project/reproject_rig.h"
#include "tests/support/guarded_part.h"
#include "tests/support/recorded_scenes.h"

namespace stof::dsp {
namespace {

constexpr int kWidth = 200;
constexpr int kHeight = 160;
constexpr int kDisparities = 64;
constexpr int kFirst = 20;  // min_disparity

// Both cameras at one place and of one kind, so that a pixel sees what the PMD pixel (x / 8, y / 8)
// does. Z = 60 / d: 20 .. 83 px are 3 m .. 0.72 m.
Calibration plain_rig() {
  Calibration rig;
  rig.stereo.left = {
      .width = kWidth, .height = kHeight, .fx = 400, .fy = 400, .cx = 99.5, .cy = 79.5};
  rig.stereo.baseline_m = 0.15;
  rig.pmd.lens = {.width = 25, .height = 20, .fx = 50, .fy = 50, .cx = 12, .cy = 9.5};
  return rig;
}

// The PMD's maps of a wall.
struct Wall : Frame {
  test::GuardedImage<QuarterMm> sigma;
  std::uint32_t range = 0;

  // At Z = depth_m for this rig's lens, with a sigma in percent.
  Wall(const Calibration& rig, double depth_m, double percent = 1)
      : Frame(rig.pmd.lens.width, rig.pmd.lens.height),
        sigma(rig.pmd.lens.width, rig.pmd.lens.height, rig.pmd.lens.width) {
    const Pinhole& lens = rig.pmd.lens;
    for (int y = 0; y < lens.height; ++y) {
      for (int x = 0; x < lens.width; ++x) {
        const double u = (x - lens.cx) / lens.fx;
        const double v = (y - lens.cy) / lens.fy;
        set(x, y, depth_m * std::sqrt(1 + u * u + v * v), percent);
      }
    }
  }
  void set(int x, int y, double metres, double percent, std::uint8_t flag = 0) {
    const double noise = metres * percent / 100;
    const auto quarters = [](double m) { return static_cast<int>(std::lround(m * 4000)); };
    put(x, y, quarters(metres - 2 * noise), quarters(metres), quarters(metres + 2 * noise), flag);
    sigma.view().at(x, y) = static_cast<QuarterMm>(quarters(noise));
  }
  void lose(int x, int y) {
    put(x, y, 0, 0, 0, kPmdLowRatio);
    sigma.view().at(x, y) = 0;
  }
  PmdMaps maps() {
    PmdMaps maps = Frame::maps();
    maps.sigma = sigma.view();
    maps.range = range;
    return maps;
  }
};

// A GuideMaker, its memory and what it makes.
class Maker {
 public:
  explicit Maker(const Calibration& rig, const GuideParams& params = {}, int width = kWidth,
                 int height = kHeight, int first = kFirst, int count = kDisparities)
      : maker_([&](Arena& arena) {
          return GuideMaker(rig, params, first, count, width, height, arena);
        }) {}
  Guide operator()(const PmdMaps& maps) { return maker_->make(maps); }

 private:
  test::GuardedPart<GuideMaker> maker_;
};

int silent_pixels(Guide guide) {
  int count = 0;
  for (int y = 0; y < guide.height(); ++y) {
    count += static_cast<int>(std::ranges::count(guide.row(y), Candidates{}));
  }
  return count;
}

double candidate(double depth_m) { return 60 / depth_m - kFirst; }

TEST(Guide, HoldsTheWallWithFourSigmaAndTheMargin) {
  const Calibration rig = plain_rig();
  for (const double depth : {0.9, 1.5, 2.2}) {
    Wall wall(rig, depth, 1);
    Maker maker(rig, {.margin = 0.07, .sigmas = 4});
    const Candidates may = maker(wall.maps()).at(kWidth / 2, kHeight / 2);
    // A step of the table is 4 mm, a reading 1/4 mm.
    EXPECT_LE(may.first, std::floor(candidate(depth * 1.04 * 1.07)));
    EXPECT_GE(may.first, std::floor(candidate(depth * 1.04 * 1.07 + 0.005)));
    EXPECT_GE(may.last, std::ceil(candidate(depth * 0.96 * 0.93)));
    EXPECT_LE(may.last, std::ceil(candidate(depth * 0.96 * 0.93 - 0.005)));
  }
}

TEST(Guide, SaysNothingWhereAReadingIsAnEdgeOrNoisy) {
  const Calibration rig = plain_rig();
  Maker maker(rig, {.most_sigma = 0.05, .reach = 4});
  Wall wall(rig, 1.5, 1);
  EXPECT_EQ(maker(wall.maps()).at(104, 80), maker(wall.maps()).at(60, 60));
  EXPECT_NE(maker(wall.maps()).at(104, 80), Candidates{});
  wall.set(13, 10, 1.5, 1, kPmdEdge);  // sees columns 104 .. 111, rows 80 .. 87
  EXPECT_EQ(maker(wall.maps()).at(107, 83), Candidates{});
  EXPECT_EQ(maker(wall.maps()).at(107 - 3 - 4, 83), Candidates{});  // within reach
  EXPECT_NE(maker(wall.maps()).at(60, 60), Candidates{});
  wall.set(13, 10, 1.5, 4.9);
  EXPECT_NE(maker(wall.maps()).at(107, 83), Candidates{});
  wall.set(13, 10, 1.5, 5.2);
  EXPECT_EQ(maker(wall.maps()).at(107, 83), Candidates{});
  wall.set(13, 10, 1.5, 1, kPmdOutOfRange);
  EXPECT_EQ(maker(wall.maps()).at(107, 83), Candidates{});
}

TEST(Guide, SaysNothingAtAStepOrAtTheEndOfWhatIsSplatted) {
  const Calibration rig = plain_rig();
  Maker maker(rig, {.reach = 3});
  Wall wall(rig, 1.2);
  for (int y = 0; y < 20; ++y) {
    for (int x = 15; x < 25; ++x) {
      wall.set(x, y, 2.2, 1);  // behind, without a flag
    }
  }
  const Guide guide = maker(wall.maps());
  int edge = 0;  // the last column that the nearer wall covers
  for (int x = 0; x < kWidth; ++x) {
    edge = guide.at(x, 80) != Candidates{} && guide.at(x, 80).first > candidate(1.6) ? x : edge;
  }
  EXPECT_GT(edge, 100);
  for (int x = edge + 1; x < edge + 6; ++x) {
    EXPECT_EQ(guide.at(x, 80), Candidates{}) << x;
  }
  EXPECT_LT(guide.at(edge + 12, 80).last, candidate(1.6));
  // A picture that is wider than what the PMD sees.
  Calibration narrow = rig;
  narrow.pmd.lens.cx = 6;  // nothing is seen left of 0.12 to the side: column 51.5
  Wall part(narrow, 1.5);
  Maker other(narrow, {.reach = 3});
  const Guide cut = other(part.maps());
  EXPECT_EQ(cut.at(40, 80), Candidates{});
  EXPECT_EQ(cut.at(49, 80), Candidates{});
  EXPECT_NE(cut.at(60, 80), Candidates{});
}

TEST(Guide, LeavesRoomForWhatThePmdCouldNotMeasureBeforeAWall) {
  Calibration rig = plain_rig();
  rig.pmd_to_stereo.translation_m = {0.3, 0, 0};
  Wall wall(rig, 2.0);
  Maker maker(rig);
  const int free = silent_pixels(maker(wall.maps()));
  // PMD pixels 10 .. 13 (-0.04 .. 0.02 to the side) see nothing in rows 8 .. 11. A thing there at
  // Z would stand at 99.5 + 400 (x + 0.3 / Z): from 140 at 2 m to 230 at 0.8 m.
  for (int y = 8; y < 12; ++y) {
    for (int x = 10; x < 14; ++x) {
      wall.lose(x, y);
    }
  }
  const Guide guide = maker(wall.maps());
  EXPECT_GT(silent_pixels(guide), free);
  for (int x = 150; x < kWidth; ++x) {
    EXPECT_EQ(guide.at(x, 80), Candidates{}) << x;
  }
  EXPECT_NE(guide.at(150, 20), Candidates{});
  // A single reading that misses among good ones hides nothing, the hole in the splats is all.
  Wall hole(rig, 2.0);
  hole.lose(11, 9);
  EXPECT_NE(maker(hole.maps()).at(190, 76), Candidates{});
  // What may stand behind a wall is hidden from both.
  Calibration near_rig = rig;
  Wall near(near_rig, 0.74);
  Maker near_maker(near_rig);
  const int near_free = silent_pixels(near_maker(near.maps()));
  for (int y = 8; y < 12; ++y) {
    near.lose(2, y);
    near.lose(3, y);
  }
  EXPECT_LT(silent_pixels(near_maker(near.maps())), near_free + 60 * 60);
}

TEST(Guide, AWrapCountInDoubtLimitsTheNearSideOnly) {
  const Calibration rig = plain_rig();
  Wall wall(rig, 1.5);
  wall.range = 7495 * 4;
  Maker certain(rig);
  const Candidates both = certain(wall.maps()).at(100, 80);
  Maker doubtful(rig, {.farthest_m = 10});
  const Candidates one = doubtful(wall.maps()).at(100, 80);
  EXPECT_EQ(one.first, 0);
  EXPECT_EQ(one.last, both.last);
  EXPECT_GT(both.first, 0);
  Maker small_hall(rig, {.farthest_m = 8});  // nothing lies at 1.5 m + 7.495 m
  EXPECT_EQ(small_hall(wall.maps()).at(100, 80), both);
}

TEST(Guide, NoCandidateMatchesASurfaceOutsideOfTheSearch) {
  const Calibration rig = plain_rig();
  Maker maker(rig);
  for (const double depth : {0.5, 4.5}) {
    Wall wall(rig, depth);
    const Candidates may = maker(wall.maps()).at(100, 80);
    const int last = std::min<int>(may.last, kDisparities - 1);
    EXPECT_GT(may.first, last) << depth;
  }
}

TEST(Guide, ServesParallelRigsWithAPmd) {
  Calibration rig = plain_rig();
  EXPECT_TRUE(GuideMaker::serves(rig));
  rig.pmd.lens.width = 0;
  EXPECT_FALSE(GuideMaker::serves(rig));
  rig = plain_rig();
  rig.stereo.converging = Converging{};
  EXPECT_FALSE(GuideMaker::serves(rig));
}

TEST(Guide, EveryStereoSizeAndRange) {
  const Calibration rig = chapter_rig(31, 17);
  Wall wall(rig, 3);
  for (const int width : {1, 2, 31}) {
    for (const int height : {1, 9}) {
      for (const int count : {1, 16, 256}) {
        Maker maker(rig, {.reach = 32}, width, height, -40, count);
        const Guide guide = maker(wall.maps());
        EXPECT_EQ(guide.width(), width);
        EXPECT_EQ(guide.height(), height);
      }
    }
  }
}

using GuideOnRecordedScenes = test::RecordedScenes;
TEST_F(GuideOnRecordedScenes, HoldsTheTruth) {
  const std::filesystem::path root = test::recorded_scenes();
  for (const char* const name :
       {"stereo/Teddy", "stereo/Cones", "stereo/Venus", "stereo/Tsukuba", "tof/scenes/Plastic"}) {
    for (const char* const sensor : {"_64x16", "_176x144"}) {
      const auto scene = dataset::read_stereo_scene(root / name);
      const std::filesystem::path prefix =
          root / "tof/sim/scene" / (std::filesystem::path(name).filename().string() + sensor);
      const auto recording = dataset::read_pmd(prefix);
      ASSERT_TRUE(scene && recording) << name << sensor;
      const Calibration& rig = recording->calibration;
      test::GuardedPart<PmdConverter> converter(
          [&](Arena& arena) { return PmdConverter(rig.pmd, arena); });
      Maker maker(rig, {}, scene->left.width, scene->left.height, 0, scene->ndisp);
      const Guide guide = maker(converter->convert(recording->samples(0)));
      int guided = 0;
      int missed = 0;
      for (int y = 0; y < guide.height(); ++y) {
        for (int x = 0; x < guide.width(); ++x) {
          const float truth = scene->truth->view().at(x, y);
          const Candidates may = guide.at(x, y);
          if (std::isfinite(truth) && may != Candidates{}) {
            ++guided;
            missed += truth < may.first - 0.5F || truth > may.last + 0.5F ? 1 : 0;
          }
        }
      }
      EXPECT_GT(guided, guide.width() * guide.height() / 20) << name << sensor;
      EXPECT_LE(missed, guided / 500) << name << sensor;
    }
  }
}

}  // namespace
}  // namespace stof::dsp
