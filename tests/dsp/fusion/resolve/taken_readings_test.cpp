#include <algorithm>

#include <gtest/gtest.h>

#include "dsp/fusion/resolve/ambiguity_resolver.h"
#include "dsp/pmd/pmd_maps.h"
#include "tests/dsp/fusion/resolve/resolver_row.h"

namespace stof::dsp {
namespace {

using Seen = ResolverRow;

TEST(AmbiguityResolver, WithAMatchOnOneSideAtMostTheReadingIsTaken) {
  Seen row(200);
  row.viewed = true;
  row.match(0, 100, 25);  // 4 m, and nothing to its right
  row.see(0, 200, 8000, 13000);
  std::fill(row.reading.begin() + 100, row.reading.end(), QuarterMm{8500});
  row.reading[150] = 12500;  // more than a metre behind what may be there
  row.reading[160] = 60000;  // of an end of an interval elsewhere
  row.see(170, 180, 8000, 13000, kPmdEdge);
  row.resolve(10);
  row.expect(140, Source::kResolved, Cause::kStereoAmbiguous, 8500);
  EXPECT_EQ(row.depth[140], 8500);
  EXPECT_EQ(row.width[140], 5000);
  row.expect(150, Source::kPmd, Cause::kNone, 12500);
  EXPECT_EQ(row.low(150), 8000);
  EXPECT_EQ(row.depth[160], 13000);
  row.expect(175, Source::kPmd, Cause::kNone, 10500);  // a mixture
  row.viewed = false;  // the pair is lost: all of the row would be readings of nobody's surface
  row.resolve(10);
  row.expect(140, Source::kPmd, Cause::kNone, 10500);
}

TEST(AmbiguityResolver, BetweenTwoSurfacesAWideIntervalOfThePmdHasItsReadingAsItsDepth) {
  Seen row(300);
  row.viewed = true;
  row.match(0, 100, 50);
  row.match(200, 300, 40);  // behind, to the right: no shadow
  row.see(0, 300, 7000, 11000);
  std::ranges::fill(row.reading, QuarterMm{7400});
  row.see(160, 161, 8000, 8100);  // narrow
  row.reading[160] = 8010;
  row.resolve();
  row.expect(150, Source::kPmd, Cause::kNone, 7400);
  EXPECT_EQ(row.depth[150], 7400);
  EXPECT_EQ(row.width[150], 2 * 3600);
  EXPECT_EQ(row.depth[160], 8050);
}

TEST(AmbiguityResolver, WidePmdPixelsLeaveMoreOfAGapToTheBackground) {
  Seen row(300);
  row.match(0, 130, 25);
  row.match(200, 300, 50);
  row.see(0, 300, 7000, 18000);
  row.resolve(1000, 0, 0, true);
  const std::size_t last = 200 - 25 - kWideShadowMargin;
  row.expect(200 - 28, Source::kResolved, Cause::kOccluded, 16000);
  EXPECT_LT(row.width[200 - 28], 3000);
  row.expect(200 - 29, Source::kResolved, Cause::kOccluded, 16000);
  EXPECT_LE(row.low(200 - 29), 7000);  // and may be what is nearer
  row.expect(last, Source::kResolved, Cause::kOccluded, 16000);
  row.expect(last - 1, Source::kPmd, Cause::kNone, 12500);
}

TEST(AmbiguityResolver, AMatchThatTellsNothingSaysWhatThePmdSays) {
  Seen row(200);
  row.see(0, 200, 12000, 18000);
  row.match(0, 100, 25, kVaguestRatio);
  row.match(100, 150, 25, kVaguestRatio - 1);
  row.weak[170] = Disparity::from_pixels(25);
  row.resolve();
  row.expect(50, Source::kBoth, Cause::kNone, 16000);
  EXPECT_LE(row.low(50), 12000);
  EXPECT_GE(row.high(50), 18000);
  EXPECT_LT(row.width[120], 1500);
  row.expect(170, Source::kBoth, Cause::kNone, 16000);
  EXPECT_LE(row.low(170), 12000);
  // Without an edge nothing speaks for a surface that is nearer by far.
  row.see(0, 200, 7000, 18000);
  row.resolve();
  row.expect(50, Source::kBoth, Cause::kNone, 16000);
}

}  // namespace
}  // namespace stof::dsp
