#include "dsp/fusion/resolve/hole_filler.h"

#include <algorithm>
#include <initializer_list>
#include <random>
#include <vector>

#include <gtest/gtest.h>

#include "tests/dsp/fusion/resolve/evidence_scene.h"
#include "tests/support/guarded_memory.h"
#include "tests/support/guarded_part.h"

namespace stof::dsp {
namespace {

using test::kHeight;
using test::kRange;
using test::kWidth;

constexpr QuarterMm kMaxRange = 64000;

// A map of a wall that both sensors see, and a PMD picture whose readings are too vague to be
// published: between 2 m and 4.25 m.
class Map {
 public:
  explicit Map(int w = kWidth, int h = kHeight, QuarterMm wall = 12000, double focal = 150)
      : scene(focal),
        depth(w, h, w, wall),
        width(w, h, w, 200),
        source(w, h, w, Source::kBoth),
        cause(w, h, w, Cause::kNone),
        disparity(w, h, w),
        low(w, h, w, 1),
        high(w, h, w, 0),
        filler_([&](Arena& arena) { return HoleFiller(w, h, kMaxRange, arena); }) {
    for (int y = 0; y < h; ++y) {
      std::ranges::fill(disparity.view().row(y), Disparity::none());
    }
    scene.see(8000, 17000);
  }

  DepthMap map() { return {depth.view(), width.view(), source.view(), cause.view()}; }
  void put(int x, int y, QuarterMm z, QuarterMm w, Source from, Cause why = Cause::kNone) {
    depth.view().at(x, y) = z;
    width.view().at(x, y) = w;
    source.view().at(x, y) = from;
    cause.view().at(x, y) = why;
  }
  void put(int begin, int end, QuarterMm z) {
    for (int y = 0; y < depth.view().height(); ++y) {
      for (int x = begin; x < end; ++x) {
        put(x, y, z, z == kNoDepth ? 0 : 200, z == kNoDepth ? Source::kNone : Source::kBoth);
      }
    }
  }
  // Something nearer, left of the hole in rows 20 to 27.
  void put_nearer(QuarterMm z) {
    for (int y = 20; y < 28; ++y) {
      for (int x = 0; x < 24; ++x) {
        put(x, y, z, 200, Source::kBoth);
      }
    }
  }
  // Columns 24 to 39 are a hole.
  void open() { put(24, 40, kNoDepth); }
  void fill(int rows = 1 << 10) {
    const int end = filler_->cell_rows().end;
    for (int y = 0; y < end; y += rows) {
      filler_->gather({y, std::min(y + rows, end)}, map());
    }
    for (int y = 0; y < end; y += rows) {
      filler_->fill({y, std::min(y + rows, end)}, {disparity.view(), low.view(), high.view()},
                    scene.evidence, map());
    }
  }
  Source source_at(int x, int y) { return source.view().at(x, y); }
  Cause cause_at(int x, int y) { return cause.view().at(x, y); }
  QuarterMm depth_at(int x, int y) { return depth.view().at(x, y); }
  QuarterMm width_at(int x, int y) { return width.view().at(x, y); }

  test::EvidenceScene scene;
  stof::test::GuardedImage<QuarterMm> depth;
  stof::test::GuardedImage<QuarterMm> width;
  stof::test::GuardedImage<Source> source;
  stof::test::GuardedImage<Cause> cause;
  stof::test::GuardedImage<Disparity> disparity;
  stof::test::GuardedImage<QuarterMm> low;
  stof::test::GuardedImage<QuarterMm> high;

 private:
  stof::test::GuardedPart<HoleFiller> filler_;
};

TEST(HoleFiller, AHoleInAWallIsThatWallAndSaysSo) {
  Map map;
  map.open();
  map.fill();
  EXPECT_EQ(map.source_at(32, 24), Source::kResolved);
  EXPECT_EQ(map.cause_at(32, 24), Cause::kInterpolated);
  EXPECT_EQ(map.depth_at(32, 24), 12000);
  EXPECT_EQ(map.width_at(32, 24), 2 * 3000);  // a quarter to either side
  EXPECT_EQ(map.source_at(23, 24), Source::kBoth);
  EXPECT_EQ(map.width_at(23, 24), 200);
}

TEST(HoleFiller, AHoleBetweenTwoSurfacesIsTheFartherAndItsIntervalHoldsBoth) {
  Map map;
  map.put_nearer(8500);
  map.open();
  map.fill();
  EXPECT_EQ(map.depth_at(32, 24), 12000);
  EXPECT_EQ(map.width_at(32, 24), 2 * 3500);
}

TEST(HoleFiller, WhereMoreThanAMetreIsOpenNothingIsPublished) {
  Map map;
  map.put_nearer(7990);
  map.open();
  map.fill();
  EXPECT_EQ(map.source_at(32, 24), Source::kNone);
  EXPECT_EQ(map.depth_at(32, 24), kNoDepth);
}

TEST(HoleFiller, AGuessBeyondFourMetresNeedsAReading) {
  for (const QuarterMm wall : {QuarterMm{16000}, QuarterMm{16100}}) {
    Map map(kWidth, kHeight, wall);
    map.open();
    map.fill();
    EXPECT_EQ(map.source_at(32, 24), wall == 16000 ? Source::kResolved : Source::kNone);
  }
  Map map(kWidth, kHeight, 34000);
  map.open();
  map.scene.read(34500 - kRange, 20);
  map.fill();
  EXPECT_EQ(map.source_at(32, 24), Source::kResolved);
  EXPECT_EQ(map.cause_at(32, 24), Cause::kRangeAmbiguous);
  EXPECT_NEAR(map.depth_at(32, 24), 34500, 30);
  EXPECT_NEAR(map.width_at(32, 24), 2 * (40 + 1020), 30);
}

TEST(HoleFiller, AGuessWithoutAReadingNeedsThreeSurfaces) {
  for (const int surfaces : {2, 3}) {
    Map map;
    map.put(0, kWidth, kNoDepth);
    for (int k = 0; k < surfaces; ++k) {  // left, right and above
      map.put(k == 2 ? 32 : 12 + 40 * k, k == 2 ? 4 : 24, 12000, 200, Source::kBoth);
    }
    map.fill();
    EXPECT_EQ(map.source_at(33, 25), surfaces == 3 ? Source::kResolved : Source::kNone);
  }
}

// Such as a black box before a wall, which neither reflects light nor has any texture.
TEST(HoleFiller, WhereThePmdSeesNothingNothingIsFilled) {
  Map map;
  map.open();
  map.scene.see(kNoDepth, kNoDepth);
  map.fill();
  EXPECT_EQ(map.source_at(32, 24), Source::kNone);
  EXPECT_EQ(map.depth_at(32, 24), kNoDepth);
}

TEST(HoleFiller, WhatThePmdSeesElsewhereIsNotFilled) {
  Map map;
  map.open();
  map.scene.read(20000, 20);
  map.fill();
  EXPECT_EQ(map.source_at(32, 24), Source::kNone);
  Map other;
  other.open();
  other.scene.see(8000, 8100);
  other.fill();
  EXPECT_EQ(other.source_at(32, 24), Source::kNone);
}

TEST(HoleFiller, BesideAMuchNearerSurfaceNothingIsPublishedThoughAReadingSeesTheFarOne) {
  Map map(kWidth, kHeight, 34000);
  map.put(0, 16, 29000);
  map.put(16, 40, kNoDepth);
  map.scene.read(34000 - kRange, 20);
  map.fill();
  for (int x = 16; x < 32; ++x) {  // two cells
    EXPECT_EQ(map.source_at(x, 24), Source::kNone) << x;
  }
  for (int x = 32; x < 40; ++x) {
    EXPECT_EQ(map.source_at(x, 24), Source::kResolved) << x;
  }
}

// A guess at (32, 24), 4 m, whose surroundings are 3 m away at these columns of row 24.
Source guess_beside(std::initializer_list<int> columns, QuarterMm end, QuarterMm beside,
                    double focal = 150, Source source = Source::kResolved) {
  Map map(kWidth, kHeight, 16000, focal);
  map.put(32, 24, 16000, 4000, source, source == Source::kPmd ? Cause::kNone : Cause::kOccluded);
  map.put(38, 24, beside, 200, Source::kBoth);
  for (const int x : columns) {
    map.low.view().at(x, 24) = 9000;
    map.high.view().at(x, 24) = end;
  }
  map.fill();
  return map.source_at(32, 24);
}

TEST(HoleFiller, AGuessBesideReadingsThatAreNearerByAMetreIsDropped) {
  EXPECT_EQ(guess_beside({36, 40}, 11999, 11999), Source::kConflict);
  EXPECT_EQ(guess_beside({28, 24}, 11999, 11999), Source::kConflict);
  EXPECT_EQ(guess_beside({36, 40}, 12000, 11999), Source::kResolved);  // not by a metre
  EXPECT_EQ(guess_beside({36, 40}, 11999, 12000), Source::kResolved);
  EXPECT_EQ(guess_beside({36}, 11999, 11999), Source::kResolved);
  EXPECT_EQ(guess_beside({35, 37, 41}, 11999, 11999), Source::kResolved);  // not those asked
  EXPECT_EQ(guess_beside({36, 40}, 11999, 11999, 150, Source::kPmd), Source::kConflict);
  EXPECT_EQ(guess_beside({36, 40}, 11999, 11999, 150, Source::kBoth), Source::kBoth);
}

TEST(HoleFiller, WherePmdPixelsAreWideAGuessBesideThemStays) {
  EXPECT_EQ(guess_beside({36, 40}, 11999, 11999, 70), Source::kResolved);
}

TEST(HoleFiller, AConflictOfSoundSensorsStaysOne) {
  Map map;
  map.put(32, 24, 0, 0, Source::kConflict, Cause::kContradiction);
  map.put(33, 24, 0, 0, Source::kConflict, Cause::kMixedPixel);
  map.fill();
  EXPECT_EQ(map.source_at(32, 24), Source::kConflict);
  EXPECT_EQ(map.source_at(33, 24), Source::kResolved);
}

TEST(HoleFiller, AWidePmdIntervalTakesTheSurfaceThatItHolds) {
  Map map;
  const auto see = [&](int x, QuarterMm low, QuarterMm high) {
    map.put(x, 24, static_cast<QuarterMm>((low + high) / 2), static_cast<QuarterMm>(high - low),
            Source::kPmd);
    map.low.view().at(x, 24) = low;
    map.high.view().at(x, 24) = high;
  };
  see(20, 9000, 13000);
  see(21, 12500, 14500);  // without the wall
  see(22, 11800, 12300);  // narrow
  see(23, 7000, 13000);   // the wall is more than a metre behind its near end
  map.fill();
  EXPECT_EQ(map.source_at(20, 24), Source::kResolved);
  EXPECT_EQ(map.cause_at(20, 24), Cause::kStereoAmbiguous);
  EXPECT_EQ(map.depth_at(20, 24), 12000 - 12000 / 64);  // towards what the PMD read
  EXPECT_EQ(map.width_at(20, 24), 2 * (3000 - 12000 / 64));
  for (int x = 21; x < 24; ++x) {
    EXPECT_EQ(map.source_at(x, 24), Source::kPmd) << x;
  }
}

TEST(HoleFiller, AnySizeAndAnySplitGivesTheSame) {
  std::mt19937 random(7);
  for (const auto& [w, h] :
       {std::pair{1, 1}, {5, 9}, {8, 8}, {15, 17}, {16, 16}, {17, 15}, {kWidth, kHeight}}) {
    Map one(w, h);
    Map other(w, h);
    for (int y = 0; y < h; ++y) {
      for (int x = 0; x < w; ++x) {
        const bool hole = random() % 3 != 0;
        const auto z = static_cast<QuarterMm>(hole ? 0 : 9000 + random() % 6000);
        for (Map* map : {&one, &other}) {
          map->put(x, y, z, hole ? 0 : 300, hole ? Source::kNone : Source::kStereo);
        }
      }
    }
    one.fill();
    other.fill(1);
    for (int y = 0; y < h; ++y) {
      EXPECT_TRUE(std::ranges::equal(one.depth.view().row(y), other.depth.view().row(y)));
      EXPECT_TRUE(std::ranges::equal(one.width.view().row(y), other.width.view().row(y)));
      EXPECT_TRUE(std::ranges::equal(one.cause.view().row(y), other.cause.view().row(y)));
    }
  }
}

}  // namespace
}  // namespace stof::dsp
