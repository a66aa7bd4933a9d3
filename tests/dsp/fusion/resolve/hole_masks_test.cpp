#include "dsp/fusion/resolve/hole_masks.h"

#include <algorithm>
#include <array>

#include <gtest/gtest.h>

#include "dsp/fusion/resolve/ambiguity_resolver.h"
#include "tests/support/kernel_check.h"

namespace stof::dsp {
namespace {

constexpr Disparity kSome = Disparity::from_pixels(3);

struct Pixel {
  Source source = Source::kNone;
  Cause cause = Cause::kNone;
  QuarterMm depth = 1250;
  QuarterMm width = 100;
  Disparity disparity = Disparity::none();
};

struct Marked {
  bool hole = false;
  bool loose = false;
  bool guess = false;
  friend bool operator==(const Marked&, const Marked&) = default;
};

Marked run(const Pixel& p) {
  std::array<std::uint64_t, 3> words{7, 7, 7};
  const auto word = [&](std::size_t k) { return std::span(words).subspan(k, 1); };
  best::hole_masks({{&p.depth, 1}, {&p.width, 1}, {&p.source, 1}, {&p.cause, 1}, {&p.disparity, 1}},
                   {word(0), word(1), word(2)});
  EXPECT_LE(words[0] | words[1] | words[2], 1U);
  return {words[0] != 0, words[1] != 0, words[2] != 0};
}

TEST(HoleMasks, APixelWithoutDepthIsAHoleUnlessBothSensorsAreSound) {
  const Marked hole{.hole = true};
  EXPECT_EQ(run({.source = Source::kNone}), hole);
  EXPECT_EQ(run({.source = Source::kNone, .cause = Cause::kStereoAmbiguous}), hole);
  EXPECT_EQ(run({.source = Source::kConflict, .cause = Cause::kMixedPixel}), hole);
  EXPECT_EQ(run({.source = Source::kConflict, .cause = Cause::kContradiction}), Marked{});
}

TEST(HoleMasks, AWidePmdIntervalIsLoose) {
  EXPECT_EQ(run({.source = Source::kPmd, .depth = 1249}), (Marked{.loose = true, .guess = true}));
  EXPECT_EQ(run({.source = Source::kPmd, .depth = 1250}), Marked{});
  EXPECT_EQ(run({.source = Source::kBoth, .depth = 1249}), Marked{});
  EXPECT_EQ(run({.source = Source::kPmd, .depth = 10, .width = 65534}),
            (Marked{.loose = true, .guess = true}));
}

TEST(HoleMasks, AGuessAtAnEdgeIsLooseWhereNoMatchIsBehindIt) {
  Pixel guess{.source = Source::kResolved, .cause = Cause::kMixedPixel};
  EXPECT_EQ(run(guess), (Marked{.loose = true, .guess = true}));
  guess.disparity = kSome;
  EXPECT_EQ(run(guess), Marked{.guess = true});
}

TEST(HoleMasks, WhatIsResolvedBesideAnEdgeIsAGuess) {
  for (const Cause cause : {Cause::kOccluded, Cause::kStereoAmbiguous}) {
    EXPECT_EQ(run({.source = Source::kResolved, .cause = cause}), Marked{.guess = true});
  }
  for (const Cause cause : {Cause::kRangeAmbiguous, Cause::kInterpolated}) {
    EXPECT_EQ(run({.source = Source::kResolved, .cause = cause}), Marked{});
  }
  EXPECT_EQ(run({.source = Source::kBoth, .cause = Cause::kOccluded}), Marked{});
}

HoleRow random_row(test::KernelCase& c) {
  const std::size_t n = c.length();
  const auto depth = c.array<QuarterMm>(n, 0, 65535), width = c.array<QuarterMm>(n);
  const auto disparity = c.array<Disparity>(n);
  for (std::size_t x = 0; x < n; ++x) {
    const int share = depth[x] / kNarrowShare + c.random().between(-3, 3);
    width[x] = c.random().between(0, 3) == 0 ? width[x]
                                             : static_cast<QuarterMm>(std::clamp(share, 0, 65535));
    disparity[x] = c.random().between(0, 1) == 0 ? Disparity::none() : disparity[x];
  }
  return {depth, width, c.array<Source>(n, 0, 5), c.array<Cause>(n, 0, kCauses - 1), disparity};
}

TEST(HoleMasks, EqualReferenceForEveryLength) {
  test::check_kernel(std::array<std::size_t, 10>{0, 1, 16, 63, 64, 65, 127, 128, 129, 200},
                     [](test::KernelCase& c) {
                       const HoleRow row = random_row(c);
                       const std::size_t words = (c.length() + 63) / 64;
                       const HoleMasks masks{c.array<std::uint64_t>(words),
                                             c.array<std::uint64_t>(words),
                                             c.array<std::uint64_t>(words)};
                       c.run([&] { best::hole_masks(row, masks); });
                     });
}

}  // namespace
}  // namespace stof::dsp
