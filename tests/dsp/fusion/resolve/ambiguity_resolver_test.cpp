#include "dsp/fusion/resolve/ambiguity_resolver.h"

#include <algorithm>
#include <vector>

#include <gtest/gtest.h>

#include "dsp/calib/stereo/column_tables.h"
#include "dsp/calib/stereo/disparity_table.h"
#include "dsp/pmd/converter.h"
#include "tests/dsp/fusion/resolve/resolver_row.h"
#include "tests/support/random.h"

namespace stof::dsp {
namespace {

using Row = ResolverRow;

TEST(AmbiguityResolver, WhatOnlyTheLeftCameraSeesBelongsToTheBackground) {
  Row row(200);
  row.match(0, 100, 25);    // 4 m
  row.match(125, 200, 50);  // 2 m; 25 px of shadow to its left
  row.see(0, 200, 7000, 18000);
  row.resolve();
  for (std::size_t x = 100; x < 125; ++x) {
    row.expect(x, Source::kResolved, Cause::kOccluded, 16000);
    EXPECT_LT(row.width[x], 3000);  // the PMD alone: 11000
  }
}

TEST(AmbiguityResolver, AGuessAtAnEdgeHoldsTheSurfaceThatWasNotChosen) {
  Row row(200);
  row.match(0, 100, 25);
  row.match(125, 200, 50);
  row.see(0, 200, 7000, 18000, kPmdEdge);
  row.resolve();
  for (std::size_t x = 100; x < 125; ++x) {
    row.expect(x, Source::kResolved, Cause::kOccluded, 16000);
    EXPECT_LE(row.depth[x] - row.width[x] / 2, 7000) << x;
  }
}

TEST(AmbiguityResolver, AGuessIsDroppedBesideAMuchNearerSurface) {
  Row row(200);
  row.match(0, 100, 25);    // 4 m
  row.match(125, 200, 50);  // 2 m
  row.see(0, 200, 7000, 18000, kPmdEdge);
  row.resolve(1000, 0, 3);
  row.expect(121, Source::kResolved, Cause::kOccluded, 16000);
  row.expect(122, Source::kConflict, Cause::kMixedPixel, 0);
  row.expect(124, Source::kConflict, Cause::kMixedPixel, 0);
}

TEST(AmbiguityResolver, ADroppedMatchIsNoNeighbour) {
  Row row(200);
  row.match(160, 200, 50);  // 2 m
  row.see(0, 200, 7000, 18000, kPmdEdge);
  row.weak[158] = Disparity::from_pixels(25);  // 4 m, beside it
  row.resolve(1000, 0, 8);
  row.expect(158, Source::kConflict, Cause::kMixedPixel, 0);
  row.expect(156, Source::kResolved, Cause::kMixedPixel, 8000);
  row.weak[158] = Disparity::none();
  row.match(55, 56, 25, kVagueRatio);  // may be 2.2 m nearer
  row.resolve(100);
  row.expect(55, Source::kConflict, Cause::kMixedPixel, 0);
  EXPECT_EQ(row.source[58], Source::kConflict);
}

TEST(AmbiguityResolver, AMatchWithRivalsAtAnEdgeSaysHowWrongItMayBe) {
  Row row(200);
  row.match(0, 200, 25, kVagueRatio);
  row.see(0, 100, 12000, 18000, kPmdEdge);
  row.see(100, 200, 7000, 18000, kPmdEdge);
  row.resolve();
  row.expect(50, Source::kBoth, Cause::kNone, 16000);
  EXPECT_LE(row.depth[50] - row.width[50] / 2, 12000);
  row.expect(150, Source::kConflict, Cause::kMixedPixel, 0);  // may be 2.2 m nearer
  row.match(0, 200, 25, kVagueRatio - 1);
  row.resolve();
  row.expect(150, Source::kBoth, Cause::kNone, 16000);
  EXPECT_LT(row.width[150], 3000);
}

TEST(AmbiguityResolver, AMatchFarBehindAnEdgeIsDropped) {
  Row row(40);
  row.match(0, 40, 25);                   // 4 m
  row.see(10, 15, 5700, 7000, kPmdEdge);  // more than 2.5 m nearer
  row.see(20, 25, 6600, 8000, kPmdEdge);  // less
  row.resolve();
  for (std::size_t x = 10; x < 15; ++x) {
    EXPECT_EQ(row.depth[x], kNoDepth) << x;
    EXPECT_EQ(row.source[x], Source::kConflict) << x;
    EXPECT_EQ(row.cause[x], Cause::kMixedPixel) << x;
  }
  for (std::size_t x = 20; x < 25; ++x) {
    row.expect(x, Source::kResolved, Cause::kMixedPixel, 16000);
  }
}

TEST(AmbiguityResolver, NothingIsMadeUpWithoutThePmd) {
  Row row(200);
  row.match(0, 100, 25);
  row.match(125, 200, 50);
  std::ranges::fill(row.weak, Disparity::from_pixels(25));
  row.resolve();
  for (std::size_t x = 100; x < 125; ++x) {
    row.expect(x, Source::kNone, Cause::kNone, 0);
  }
}

TEST(AmbiguityResolver, ASurfaceThatThePmdExcludesDoesNotCount) {
  Row row(200);
  row.match(0, 100, 25);
  row.match(125, 200, 50);
  row.see(100, 125, 10000, 11000, kPmdEdge);  // something between the two
  row.resolve();
  row.expect(110, Source::kPmd, Cause::kNone, 10500);
  EXPECT_EQ(row.width[110], 1000);
}

TEST(AmbiguityResolver, ShadowsAreOnlyAsWideAsTheStep) {
  Row row(300);
  row.match(0, 100, 25);
  row.match(200, 300, 50);
  row.see(0, 300, 7000, 18000);  // no edge, 100 px without a match
  row.resolve();
  row.expect(199, Source::kResolved, Cause::kOccluded, 16000);
  row.expect(200 - 28, Source::kResolved, Cause::kOccluded, 16000);
  row.expect(200 - 29, Source::kPmd, Cause::kNone, 12500);
}

TEST(AmbiguityResolver, LeftOfTheRightPictureTheNextSurfaceGoesOn) {
  Row row(200);
  row.match(60, 200, 50);
  row.see(0, 200, 7000, 18000);
  std::fill_n(row.reading.begin(), 54, QuarterMm{8000});
  row.resolve();
  row.expect(60 - kPullReach, Source::kResolved, Cause::kOccluded, 8000);
  row.expect(60 - kPullReach - 1, Source::kPmd, Cause::kNone, 12500);  // too far from the surface
  row.expect(53, Source::kResolved, Cause::kOccluded, 8000);
  row.expect(54, Source::kPmd, Cause::kNone, 12500);  // its match would lie inside
}

TEST(AmbiguityResolver, FartherLeftTheReadingCountsForMore) {
  Row row(200);
  row.match(60, 200, 50);  // 2 m
  row.see(0, 200, 7000, 18000);
  row.resolve();
  constexpr std::size_t kLast = 60 - kPullReach;
  const int surface = middle_of(7467, 8616);  // a fourteenth of the parallax to either side
  EXPECT_NEAR(row.depth[52] - surface, surface * 8.0 / kPullWay, 3);
  EXPECT_NEAR(row.depth[20] - surface, surface * 40.0 / kPullWay, 3);
  EXPECT_NEAR(row.depth[kLast] - surface, 1.0 * surface * kPullReach / kPullWay, 3);
  EXPECT_LE(row.low(kLast), 7467);
  EXPECT_GE(row.high(kLast), 8616);
  row.see(0, 200, 7000, 18000, kPmdEdge);  // a mixture
  row.resolve();
  EXPECT_NEAR(row.depth[kLast], surface, 3);
}

TEST(AmbiguityResolver, AReadingNearerThanTheLimitIsTakenAsItIs) {
  Row row(200);
  row.match(60, 200, 50);
  row.see(0, 200, 7000, 18000);
  row.reading[20] = 8000;
  row.resolve();
  EXPECT_EQ(row.depth[20], 8000);
}

// A wall of 200 at 4 m, its shadow, and from column 130 on a body of 60 at 3.3 m, whose matches
// begin in column 125.
Row fattened() {
  Row row(200);
  row.match(0, 122, 25);
  row.match(125, 200, 30);
  row.see(0, 200, 11000, 18000);
  row.picture.assign(200, 200);
  std::fill(row.picture.begin() + 130, row.picture.end(), std::uint8_t{60});
  return row;
}

TEST(AmbiguityResolver, MatchesBeforeTheEdgeInThePictureBelongToTheBackground) {
  Row row = fattened();
  row.resolve();
  for (std::size_t x = 122; x < 130; ++x) {
    row.expect(x, Source::kResolved, Cause::kOccluded, 16000);
  }
  EXPECT_LE(row.low(127), 13300);  // what the match said
  row.expect(130, Source::kBoth, Cause::kNone, 13333);
}

TEST(AmbiguityResolver, MatchesStayWhereNothingProvesThatTheyAreFattened) {
  const auto stays = [](Row row) {
    row.resolve();
    row.expect(127, Source::kBoth, Cause::kNone, 13333);
  };
  Row row = fattened();
  row.picture.clear();
  stays(row);
  row = fattened();
  std::fill(row.picture.begin() + 125, row.picture.begin() + 130, std::uint8_t{70});  // the body's
  stays(row);
  row = fattened();
  std::fill(row.picture.begin() + 130, row.picture.end(), std::uint8_t{190});  // no edge
  stays(row);
  row = fattened();
  row.see(120, 130, 12000, 14500);  // nothing of the wall
  stays(row);
  row = fattened();
  row.match(115, 125, 30);  // without a shadow
  stays(row);
}

TEST(AmbiguityResolver, NoMatchGivesWayToWhatIsAMetreBehindIt) {
  Row row = fattened();
  row.match(0, 122, 20);  // 5 m
  row.see(0, 200, 11000, 24000);
  row.resolve();
  row.expect(127, Source::kBoth, Cause::kNone, 13333);
}

TEST(AmbiguityResolver, AWeakMatchIsConfirmedAndThenANeighbour) {
  Row row(200);
  row.see(0, 200, 7000, 18000, kPmdEdge);
  row.weak[90] = Disparity::from_pixels(25);
  row.weak[120] = Disparity::from_pixels(90);  // 1.1 m: not where the PMD sees anything
  row.resolve();
  row.expect(90, Source::kBoth, Cause::kNone, 16000);
  row.expect(95, Source::kResolved, Cause::kMixedPixel, 16000);
  row.expect(120, Source::kResolved, Cause::kMixedPixel, 16000);
}

TEST(AmbiguityResolver, AGapInOneSurfaceIsThatSurface) {
  Row row(200);
  row.match(0, 90, 40);
  row.match(110, 200, 41);
  row.see(0, 200, 9000, 18000);
  row.resolve();
  row.expect(100, Source::kResolved, Cause::kStereoAmbiguous, 9877);
  EXPECT_GT(row.depth[92], row.depth[108]);  // between the two, not one of them
}

TEST(AmbiguityResolver, AtAnEdgeTheNearestSurfaceWithinReachCounts) {
  Row row(300);
  row.match(0, 100, 50);
  row.match(200, 300, 25);  // behind, to the right: no shadow
  row.see(100, 200, 7000, 18000, kPmdEdge);
  row.resolve(30);
  row.expect(110, Source::kResolved, Cause::kMixedPixel, 8000);
  row.expect(190, Source::kResolved, Cause::kMixedPixel, 16000);
  row.expect(150, Source::kConflict, Cause::kMixedPixel, 0);  // too far from both
}

TEST(AmbiguityResolver, MatchesWithRivalsAreNoSurfaces) {
  Row row(200);
  row.match(0, 100, 50, kNeighbourRatio);
  row.see(100, 200, 7000, 18000, kPmdEdge);
  row.resolve();
  row.expect(110, Source::kConflict, Cause::kMixedPixel, 0);  // anything from 1.7 to 4.5 m
  row.see(100, 200, 10000, 17000, kPmdEdge);
  row.resolve();
  row.expect(110, Source::kPmd, Cause::kNone, 13500);
}

TEST(AmbiguityResolver, AConflictAtAnEdgeIsResolvedAndOneOfSoundSensorsIsNot) {
  Row row(200);
  row.match(0, 200, 25);
  row.match(100, 110, 80, 250);  // 1.25 m, with rivals
  row.see(0, 200, 12000, 18000, kPmdEdge);
  row.match(150, 160, 80);  // sure
  row.see(150, 160, 7000, 18000);
  row.resolve();
  row.expect(105, Source::kResolved, Cause::kStereoAmbiguous, 16000);
  row.expect(155, Source::kConflict, Cause::kContradiction, 0);
}

TEST(AmbiguityResolver, AWidePmdPixelIsNoSoundWitnessAgainstTheSurestMatches) {
  for (const bool wide : {false, true}) {
    Row row(40);
    row.match(0, 10, 25, kSurestRatio - 1);       // 4 m, behind what the PMD sees
    row.match(10, 20, 25, kSurestRatio);          // not so sure
    row.match(20, 30, 80, kSureBeforeRatio - 1);  // 1.25 m, before it
    row.match(30, 40, 80, kSureBeforeRatio);
    row.see(0, 40, 8000, 10000);
    row.resolve(1000, 0, 0, wide);
    for (std::size_t x = 0; x < 40; ++x) {
      if (wide && x / 10 % 2 == 0) {
        row.expect(x, Source::kResolved, Cause::kMixedPixel, x < 10 ? 16000 : 5000);
      } else {
        row.expect(x, Source::kConflict, Cause::kContradiction, 0);
      }
    }
  }
}

TEST(AmbiguityResolver, TheSurestMatchARangeAwayStaysAConflict) {
  Row row(10);
  row.match(0, 10, 25, kSurestRatio - 1);
  row.see(0, 10, 8000, 10000);
  row.resolve(1000, 7000, 0, true);
  for (std::size_t x = 0; x < 10; ++x) {
    row.expect(x, Source::kConflict, Cause::kRangeAmbiguous, 0);
  }
}

TEST(AmbiguityResolver, ADifferenceOfOneRangeIsSaid) {
  Row row(64);
  row.match(0, 64, 10);         // 10 m = 40000
  row.see(0, 64, 9900, 10200);  // 2.5 m: 7.5 m less
  row.resolve(1000, 29979);
  EXPECT_EQ(row.source[30], Source::kConflict);
  EXPECT_EQ(row.cause[30], Cause::kRangeAmbiguous);
  row.resolve(1000, 20000);
  EXPECT_EQ(row.cause[30], Cause::kContradiction);
}

// Whatever comes in: a depth only where a sensor gave an interval, and inside the PMD's where one
// was resolved.
TEST(AmbiguityResolver, StaysWithinWhatThePmdAllows) {
  for (std::uint64_t seed = 0; seed < 200; ++seed) {
    test::Random random(seed);
    Row row(static_cast<std::size_t>(random.between(1, 90)));
    const std::size_t n = row.disparity.size();
    for (std::size_t x = 0; x < n; ++x) {
      if (random.between(0, 2) == 0) {
        row.match(x, x + 1, random.between(-1, 127), static_cast<std::uint8_t>(random.next()));
      }
      if (random.between(0, 1) == 0) {
        row.weak[x] = Disparity::from_pixels(random.between(-1, 127));
      }
      if (random.between(0, 3) != 0) {
        const int low = random.between(1, 39999);
        row.see(x, x + 1, static_cast<QuarterMm>(low),
                static_cast<QuarterMm>(random.between(low, 60000)),
                static_cast<std::uint8_t>(random.next()));
      }
    }
    for (std::size_t x = 0; x < n; ++x) {
      row.reading[x] = static_cast<QuarterMm>(random.next());
      row.picture.push_back(static_cast<std::uint8_t>(random.between(0, 3) * 60));
    }
    row.resolve(random.between(0, 100), 29979);
    for (std::size_t x = 0; x < n; ++x) {
      const bool none = row.source[x] == Source::kNone || row.source[x] == Source::kConflict;
      ASSERT_EQ(none, row.depth[x] == 0) << seed << " at " << x;
      if (row.source[x] == Source::kResolved && row.cause[x] == Cause::kOccluded) {
        ASSERT_GE(row.depth[x], row.pmd_low[x]) << seed << " at " << x;
        ASSERT_LE(row.depth[x], row.pmd_high[x]) << seed << " at " << x;
      }
      if (row.pmd_high[x] == 0 && row.stereo_high[x] == 0) {
        ASSERT_EQ(row.source[x], Source::kNone) << seed << " at " << x;
      }
    }
  }
}

TEST(AmbiguityResolver, WorksWithColumnsToo) {
  const std::size_t n = 200;
  Row row(n);
  std::vector<std::int32_t> left(n), right(right_tangents(n, -16, 128 * 16));
  const ColumnTables columns = make_column_tables(kRig, -16, 128 * 16, 40000, left, right);
  row.match(0, 100, 25);
  row.match(125, 200, 50);
  row.see(0, 200, 7000, 18000, kPmdEdge);
  ref::intersect({row.stereo_low, row.stereo_high}, {row.pmd_low, row.pmd_high},
                 {row.ratio, row.flags}, 40000, row.out());
  resolve_ambiguities({.disparity = row.disparity,
                       .weak = {},
                       .stereo = {row.stereo_low, row.stereo_high},
                       .pmd = {row.pmd_low, row.pmd_high},
                       .reading = row.reading,
                       .support = {row.ratio, row.flags}},
                      {.infinity_raw = 0, .max_range = 40000, .pmd_range = 0, .reach_px = 1000},
                      columns, row.out());
  row.expect(110, Source::kResolved, Cause::kOccluded, 16000);
}

}  // namespace
}  // namespace stof::dsp
