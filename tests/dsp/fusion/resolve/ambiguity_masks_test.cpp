#include "dsp/fusion/resolve/ambiguity_masks.h"

#include <algorithm>
#include <array>

#include <gtest/gtest.h>

#include "dsp/pmd/pmd_maps.h"
#include "tests/support/kernel_check.h"

namespace stof::dsp {
namespace {

constexpr Disparity kSome = Disparity::from_pixels(3);

struct Pixel {
  Source source = Source::kNone;
  Cause cause = Cause::kNone;
  QuarterMm low = 1200;
  QuarterMm high = 1300;
  QuarterMm near = 5000;  // of stereo
  QuarterMm far = 5100;
  QuarterMm pmd_range = 4000;
  std::uint8_t ratio = 0;
  std::uint8_t flags = 0;
  Disparity disparity = kSome;
  Disparity weak = Disparity::none();
};

struct Marked {
  bool open = false;
  bool matched = false;
  bool folded = false;
  bool weak = false;
  bool edge = false;
  bool alone = false;
  bool vague = false;
  bool unsure = false;
  friend bool operator==(const Marked&, const Marked&) = default;
};

Marked run(const Pixel& p) {
  std::array<std::uint64_t, 8> words{7, 7, 7, 7, 7, 7, 7, 7};
  const auto word = [&](std::size_t k) { return std::span(words).subspan(k, 1); };
  best::ambiguity_masks({{&p.disparity, 1},
                         {&p.weak, 1},
                         {{&p.ratio, 1}, {&p.flags, 1}},
                         {{&p.near, 1}, {&p.far, 1}},
                         {{&p.low, 1}, {&p.high, 1}},
                         {&p.source, 1},
                         {&p.cause, 1},
                         60000,
                         p.pmd_range},
                        {word(0), word(1), word(2), word(3), word(4), word(5), word(6), word(7)});
  for (const std::uint64_t bits : words) {
    EXPECT_LE(bits, 1U);
  }
  return {words[0] != 0, words[1] != 0, words[2] != 0, words[3] != 0,
          words[4] != 0, words[5] != 0, words[6] != 0, words[7] != 0};
}

TEST(AmbiguityMasks, AWidePmdIntervalIsOpen) {
  EXPECT_EQ(run({.source = Source::kPmd, .high = 1301}),
            (Marked{true, false, false, false, false}));
  EXPECT_EQ(run({.source = Source::kPmd, .high = 1300}), Marked{});
}

TEST(AmbiguityMasks, AConflictAtAnEdgeIsOpen) {
  EXPECT_EQ(run({.source = Source::kConflict, .cause = Cause::kMixedPixel, .flags = kPmdEdge}),
            (Marked{.open = true, .folded = true, .edge = true}));
}

TEST(AmbiguityMasks, AConflictOfOneRangeIsFolded) {
  const Pixel nearer{.source = Source::kConflict, .cause = Cause::kContradiction};
  EXPECT_EQ(run(nearer), Marked{.folded = true});
  Pixel other = nearer;
  other.source = Source::kPmd;
  EXPECT_EQ(run(other), Marked{});
  other = nearer;
  other.pmd_range = 0;
  EXPECT_EQ(run(other), Marked{});
}

TEST(AmbiguityMasks, ARangeIsMovedByUpToASixteenthLess) {
  Pixel pixel{.source = Source::kConflict};  // of the PMD: 1200 .. 1300
  const auto is_folded = [&](QuarterMm near, QuarterMm far) {
    pixel.near = near;
    pixel.far = far;
    return run(pixel).folded;
  };
  EXPECT_FALSE(is_folded(5301, 5400));
  EXPECT_TRUE(is_folded(5300, 5400));
  EXPECT_TRUE(is_folded(4900, 4950));
  EXPECT_FALSE(is_folded(4900, 4949));
  pixel.low = 6000;
  pixel.high = 6100;
  EXPECT_FALSE(is_folded(2351, 2400));
  EXPECT_TRUE(is_folded(2350, 2400));
  EXPECT_TRUE(is_folded(1900, 2000));
  EXPECT_FALSE(is_folded(1900, 1999));
}

TEST(AmbiguityMasks, IntervalsEndAtTheMostRange) {
  // Moved by a range it would begin at 59,750 or behind.
  Pixel far{.source = Source::kConflict, .low = 56000, .high = 56100, .near = 59800, .far = 65535};
  EXPECT_EQ(run(far), Marked{.folded = true});
  far.low = 56251;
  far.high = 56260;
  EXPECT_EQ(run(far), Marked{});
}

TEST(AmbiguityMasks, PublishedMatchesThatStandOutStandForASurface) {
  const Marked matched{.matched = true};
  const Marked matched_alone{.matched = true, .alone = true};
  EXPECT_EQ(run({.source = Source::kStereo, .ratio = kNeighbourRatio - 1}), matched_alone);
  EXPECT_EQ(run({.source = Source::kBoth}), matched);
  EXPECT_EQ(run({.source = Source::kResolved, .cause = Cause::kMixedPixel}), matched_alone);
  EXPECT_FALSE(run({.source = Source::kResolved, .cause = Cause::kStereoAmbiguous}).matched);
  EXPECT_EQ(run({.source = Source::kStereo, .ratio = kNeighbourRatio}), Marked{.alone = true});
}

TEST(AmbiguityMasks, AMatchWithRivalsAtAnEdgeOfThePmdIsVague) {
  const Pixel vague{.source = Source::kBoth, .ratio = kVagueRatio, .flags = kPmdEdge};
  EXPECT_EQ(run(vague), (Marked{.matched = true, .edge = true, .vague = true}));
  Pixel other = vague;
  other.ratio = kVagueRatio - 1;
  EXPECT_FALSE(run(other).vague);
  other = vague;
  other.flags = 0;
  EXPECT_FALSE(run(other).vague);
  other.ratio = kVaguestRatio - 1;
  EXPECT_FALSE(run(other).vague);
  other.ratio = kVaguestRatio;
  EXPECT_TRUE(run(other).vague);
  other = vague;
  other.disparity = Disparity::none();  // its weak match
  EXPECT_FALSE(run(other).vague);
}

TEST(AmbiguityMasks, AMatchAgainstThePmdIsUnsureWhereThePmdWasBelieved) {
  EXPECT_EQ(run({.source = Source::kResolved, .cause = Cause::kStereoAmbiguous}),
            Marked{.unsure = true});
  EXPECT_FALSE(run({.source = Source::kResolved, .cause = Cause::kMixedPixel}).unsure);
  EXPECT_FALSE(run({.source = Source::kNone, .cause = Cause::kStereoAmbiguous}).unsure);
}

TEST(AmbiguityMasks, AWeakMatchCountsWithoutAnother) {
  EXPECT_EQ(run({.disparity = Disparity::none(), .weak = kSome}),
            (Marked{false, false, false, true, false}));
  EXPECT_EQ(run({.weak = kSome}), Marked{});
}

MaskRow random_row(test::KernelCase& c, bool with_weak) {
  const std::size_t n = c.length();
  const auto some = [&](std::size_t count) {
    const auto out = c.array<Disparity>(count);
    for (Disparity& d : out) {
      d = c.random().between(0, 2) == 0 ? Disparity::none() : d;
    }
    return out;
  };
  const auto low = c.array<QuarterMm>(n, 0, 65535), high = c.array<QuarterMm>(n);
  for (std::size_t x = 0; x < n; ++x) {
    const int share = low[x] / kNarrowShare + c.random().between(-2, 2);
    high[x] = c.random().between(0, 3) == 0
                  ? high[x]
                  : static_cast<QuarterMm>(std::clamp(low[x] + share, 0, 65535));
  }
  const auto disparity = some(n), weak = some(with_weak ? n : 0);
  return {disparity,
          weak,
          {c.array<std::uint8_t>(n, 0, 255), c.array<std::uint8_t>(n)},
          {c.array<QuarterMm>(n), c.array<QuarterMm>(n)},
          {low, high},
          c.array<Source>(n, 0, 5),
          c.array<Cause>(n, 0, kCauses - 1),
          static_cast<QuarterMm>(c.random().between(0, 65535)),
          static_cast<QuarterMm>(std::max(c.random().between(-20000, 65535), 0))};
}

TEST(AmbiguityMasks, EqualReferenceForEveryLength) {
  for (const bool with_weak : {false, true}) {
    test::check_kernel(std::array<std::size_t, 10>{0, 1, 16, 63, 64, 65, 127, 128, 129, 200},
                       [&](test::KernelCase& c) {
                         const MaskRow row = random_row(c, with_weak);
                         const std::size_t words = (c.length() + 63) / 64;
                         const auto word = [&] { return c.array<std::uint64_t>(words); };
                         const PixelMasks masks{word(), word(), word(), word(),
                                                word(), word(), word(), word()};
                         c.run([&] { best::ambiguity_masks(row, masks); });
                       });
  }
}

}  // namespace
}  // namespace stof::dsp
