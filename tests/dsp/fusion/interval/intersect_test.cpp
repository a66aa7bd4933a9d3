#include "dsp/fusion/interval/intersect.h"

#include <algorithm>

#include <gtest/gtest.h>

#include "dsp/fusion/project/splat.h"
#include "dsp/pmd/converter.h"
#include "tests/support/kernel_check.h"

namespace stof::dsp {
namespace {

constexpr QuarterMm kMaxRange = 40000;

struct Bounds {
  QuarterMm low;
  QuarterMm high;
};
constexpr Bounds kNone{0, 0};
constexpr Bounds kNoPmd{kNoSplat, 0};

struct Fused {
  int depth;
  int width;
  Source source;
  Cause cause = Cause::kNone;
  friend bool operator==(const Fused&, const Fused&) = default;
};
constexpr std::uint8_t kSure = kSureRatio - 1;
constexpr std::uint8_t kRivals = kSureRatio;
Fused run(Bounds stereo, Bounds pmd, std::uint8_t flags = 0, QuarterMm max_range = kMaxRange,
          std::uint8_t ratio = kRivals) {
  QuarterMm depth = 7;
  QuarterMm width = 7;
  Source source{};
  Cause cause{};
  best::intersect({{&stereo.low, 1}, {&stereo.high, 1}}, {{&pmd.low, 1}, {&pmd.high, 1}},
                  {{&ratio, 1}, {&flags, 1}}, max_range,
                  {{&depth, 1}, {&width, 1}, {&source, 1}, {&cause, 1}});
  return {depth, width, source, cause};
}

TEST(Intersect, OverlapIsTheMiddleOfWhatBothAllow) {
  EXPECT_EQ(run({8000, 8400}, {8200, 9000}), (Fused{8300, 200, Source::kBoth}));
  EXPECT_EQ(run({8200, 9000}, {8000, 8400}), (Fused{8300, 200, Source::kBoth}));
}

TEST(Intersect, OneInsideTheOtherIsTheInnerOne) {
  EXPECT_EQ(run({8000, 9000}, {8200, 8400}), (Fused{8300, 200, Source::kBoth}));
  EXPECT_EQ(run({8200, 8400}, {8000, 9000}), (Fused{8300, 200, Source::kBoth}));
}

TEST(Intersect, TouchingIntervalsAgreeOnOneDepth) {
  EXPECT_EQ(run({8000, 8400}, {8400, 9000}), (Fused{8400, 0, Source::kBoth}));
}

TEST(Intersect, OneSensorAloneKeepsItsInterval) {
  EXPECT_EQ(run({8000, 8400}, kNoPmd), (Fused{8200, 400, Source::kStereo}));
  EXPECT_EQ(run({8000, 8400}, kNone), (Fused{8200, 400, Source::kStereo}));
  EXPECT_EQ(run(kNone, {8000, 8400}), (Fused{8200, 400, Source::kPmd}));
}

TEST(Intersect, BothMissingIsNoneAndNotTheMiddleOfTheRange) {
  EXPECT_EQ(run(kNone, kNoPmd), (Fused{0, 0, Source::kNone}));
}

TEST(Intersect, AMatchWithRivalsAtAnEdgeHasNoDepth) {
  const Fused conflict{0, 0, Source::kConflict, Cause::kMixedPixel};
  EXPECT_EQ(run({8000, 8400}, {8401, 9000}, kPmdEdge), conflict);
  EXPECT_EQ(run({8401, 9000}, {8000, 8400}, 0xFF), conflict);
}

TEST(Intersect, OneFlatSurfaceIsBelievedBeforeAMatchWithRivals) {
  EXPECT_EQ(run({8000, 8400}, {8401, 9001}),
            (Fused{8701, 600, Source::kResolved, Cause::kStereoAmbiguous}));
  EXPECT_EQ(run({8402, 9000}, {8000, 8400}, kPmdOutOfRange),
            (Fused{8200, 400, Source::kResolved, Cause::kStereoAmbiguous}));
}

TEST(Intersect, ASureMatchIsBelievedBeforeAMixedPixel) {
  EXPECT_EQ(run({8000, 8400}, {8401, 9001}, kPmdEdge, kMaxRange, kSure),
            (Fused{8200, 400, Source::kResolved, Cause::kMixedPixel}));
}

TEST(Intersect, TwoSoundMeasurementsThatExcludeEachOtherAreNoDepth) {
  EXPECT_EQ(run({8000, 8400}, {8401, 9001}, 0, kMaxRange, kSure),
            (Fused{0, 0, Source::kConflict, Cause::kContradiction}));
}

TEST(Intersect, EndsAtTheLargestRange) {
  EXPECT_EQ(run({39000, 50000}, kNone), (Fused{39500, 1000, Source::kStereo}));
  EXPECT_EQ(run(kNone, {40001, 50000}), (Fused{0, 0, Source::kNone}));
  EXPECT_EQ(run({39000, 50000}, {40001, 50000}), (Fused{39500, 1000, Source::kStereo}));
  EXPECT_EQ(run({39000, 50000}, {39000, 50000}, 0, 0), (Fused{0, 0, Source::kNone}));
}

TEST(Intersect, PublishesAnIntervalThatHoldsTheRealOneAndFits) {
  for (const Bounds bounds : {Bounds{1, 2},
                              {1, 1},
                              {1, 65535},
                              {2, 65535},
                              {65534, 65535},
                              {65535, 65535},
                              {7, 12},
                              {7, 13},
                              {0, 5}}) {
    const Fused fused = run(bounds, kNone, 0, 65535);
    const int lo = fused.depth - fused.width / 2;
    const int hi = fused.depth + fused.width / 2;
    EXPECT_EQ(fused.width % 2, 0);
    EXPECT_GE(lo, 0);
    EXPECT_LE(hi, 65535);
    EXPECT_LE(lo, std::max<int>(bounds.low, 1));
    EXPECT_GE(hi, bounds.high);
    EXPECT_LE(hi - lo, bounds.high - std::max<int>(bounds.low, 1) + 1);
    EXPECT_GT(fused.depth, 0);
  }
}

TEST(Intersect, EqualsReferenceForEveryLengthAndExtreme) {
  for (const int spread : {6, 3000, 65535}) {
    for (const QuarterMm range : {QuarterMm{0}, QuarterMm{1}, QuarterMm{2000}, kMaxQuarterMm}) {
      test::check_kernel([&](test::KernelCase& c) {
        const std::size_t n = c.length();
        const auto intervals = [&] {
          const auto low = c.array<QuarterMm>(n, 0, spread),
                     high = c.array<QuarterMm>(n, 0, spread);
          for (std::size_t x = 0; x < n; ++x) {
            const int kind = c.random().between(0, 9);
            if ((low[x] > high[x]) != (kind == 2)) {
              std::swap(low[x], high[x]);
            }
            low[x] = kind == 0 ? kNoSplat : low[x];
            high[x] = kind <= 1 ? kNoDepth : high[x];
          }
          return IntervalRow{low, high};
        };
        const IntervalRow stereo = intervals(), pmd = intervals();
        const SupportRow support{c.array<std::uint8_t>(n, 0, 255), c.array<std::uint8_t>(n)};
        const FusedRow out{c.array<QuarterMm>(n), c.array<QuarterMm>(n), c.array<Source>(n),
                           c.array<Cause>(n)};
        c.run([&] { best::intersect(stereo, pmd, support, range, out); });
      });
    }
  }
}

}  // namespace
}  // namespace stof::dsp
