#include "dsp/fusion/resolve/surrounding_matches.h"

#include <vector>

#include <gtest/gtest.h>

#include "dsp/fusion/resolve/ambiguity_resolver.h"
#include "dsp/pmd/pmd_maps.h"
#include "tests/dsp/fusion/resolve/resolver_row.h"

namespace stof::dsp {
namespace {

constexpr int kRows = 17;
constexpr int kMiddle = 8;

// A row in the middle of a view of one disparity.
struct Surrounded {
  explicit Surrounded(int px, std::size_t n = 100)
      : row(n), disparity(n * kRows, Disparity::from_pixels(px)) {
    row.around = view();
    row.y = kMiddle;
  }
  ImageView<Disparity> view() {
    return {disparity.data(), static_cast<int>(row.disparity.size()), kRows};
  }

  ResolverRow row;
  std::vector<Disparity> disparity;
};

TEST(SurroundingMatches, AreCountedBeforeARangeInItAndBehindIt) {
  Surrounded scene(25);  // 4 m, 16000
  const auto found = [&](int x, int y, DepthRange range) {
    return surrounding_matches(ImageView<const Disparity>(scene.view()), x, y, scene.row.table,
                               range);
  };
  EXPECT_EQ(found(50, kMiddle, {15000, 17000}).within, 16);
  EXPECT_EQ(found(50, kMiddle, {8000, 9000}).behind, 16);
  EXPECT_EQ(found(50, kMiddle, {20000, 30000}).before, 16);
  EXPECT_EQ(found(0, 0, {15000, 17000}).within, 6);  // the others are outside
  scene.view().at(46, kMiddle) = Disparity::from_pixels(50);
  scene.view().at(54, kMiddle) = Disparity::none();
  scene.view().at(50, kMiddle) = Disparity::from_pixels(50);  // not one of those around
  scene.view().at(50, 4) = Disparity::from_pixels(1);         // beyond what is told
  const SurroundingMatches some = found(50, kMiddle, {15000, 17000});
  EXPECT_EQ(some.before, 1);
  EXPECT_EQ(some.behind, 1);
  EXPECT_EQ(some.within, 13);
  const DepthRange surfaces =
      surrounding_surfaces(ImageView<const Disparity>(scene.view()), 50, kMiddle, scene.row.table);
  EXPECT_NEAR(surfaces.low, 8000, 2);
  EXPECT_EQ(surfaces.high, kMaxQuarterMm);
}

// A pane of glass looks so.
TEST(AmbiguityResolver, ThePmdIsNotBelievedAgainstIndistinctMatchesThatAllLieBehindIt) {
  Surrounded scene(20);
  scene.row.match(0, 100, 20, kSureRatio + 20);  // 5 m
  scene.row.see(0, 100, 12000, 12400);
  scene.row.resolve();
  scene.row.expect(50, Source::kConflict, Cause::kContradiction, 0);
  for (Disparity& match : scene.disparity) {
    match = Disparity::from_pixels(60);  // the pixel's own stays: it is the only one behind
  }
  scene.row.resolve();
  scene.row.expect(50, Source::kResolved, Cause::kStereoAmbiguous, 12200);
}

TEST(AmbiguityResolver, NorAgainstThoseThatAllAreNearerByAMetre) {
  Surrounded scene(50);  // 2 m
  scene.row.match(0, 100, 50, kSureRatio + 20);
  scene.row.see(0, 50, 13000, 13400);
  scene.row.see(50, 100, 11000, 11400);  // within a metre: no collision
  scene.row.resolve();
  scene.row.expect(20, Source::kConflict, Cause::kContradiction, 0);
  scene.row.expect(70, Source::kResolved, Cause::kStereoAmbiguous, 11200);
}

TEST(AmbiguityResolver, AnEdgeOfThePmdHasAnIntervalForWhatLiesBesideTheSurface) {
  Surrounded scene(25);
  scene.row.see(0, 50, 15900, 16100, kPmdEdge);
  scene.row.see(50, 100, 15900, 16100);
  scene.row.resolve();
  EXPECT_EQ(scene.row.width[20], 2 * (16000 / 32));
  EXPECT_EQ(scene.row.width[70], 200);
}

}  // namespace
}  // namespace stof::dsp
