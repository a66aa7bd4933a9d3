#include "dsp/fusion/resolve/ambiguity_masks.h"

#include <algorithm>
#include <array>
#include <vector>

#include <gtest/gtest.h>

#include "dsp/pmd/pmd_maps.h"
#include "tests/support/guarded.h"
#include "tests/support/random.h"
#include "tests/support/vectors.h"

namespace stof::dsp {
namespace {

constexpr Disparity kSome = Disparity::from_pixels(3);

struct Pixel {
  Source source = Source::kNone;
  Cause cause = Cause::kNone;
  QuarterMm low = 1200;
  QuarterMm high = 1300;
  std::uint8_t ratio = 0;
  std::uint8_t flags = 0;
  Disparity disparity = kSome;
  Disparity weak = Disparity::none();
};

struct Marked {
  bool open;
  bool matched;
  bool disputed;
  bool weak;
  bool edge;
  friend bool operator==(const Marked&, const Marked&) = default;
};

Marked run(const Pixel& p) {
  std::array<std::uint64_t, 5> words{7, 7, 7, 7, 7};
  const auto word = [&](std::size_t k) { return std::span(words).subspan(k, 1); };
  ref::ambiguity_masks({{&p.disparity, 1},
                        {&p.weak, 1},
                        {{&p.ratio, 1}, {&p.flags, 1}},
                        {{&p.low, 1}, {&p.high, 1}},
                        {&p.source, 1},
                        {&p.cause, 1}},
                       {word(0), word(1), word(2), word(3), word(4)});
  for (const std::uint64_t bits : words) {
    EXPECT_LE(bits, 1U);
  }
  return {words[0] != 0, words[1] != 0, words[2] != 0, words[3] != 0, words[4] != 0};
}

TEST(AmbiguityMasks, AWidePmdIntervalIsOpen) {
  EXPECT_EQ(run({.source = Source::kPmd, .high = 1301}),
            (Marked{true, false, false, false, false}));
  EXPECT_EQ(run({.source = Source::kPmd, .high = 1300}), Marked{});
}

TEST(AmbiguityMasks, AConflictAtAnEdgeIsOpenAndAnyConflictDisputed) {
  EXPECT_EQ(run({.source = Source::kConflict, .cause = Cause::kMixedPixel, .flags = kPmdEdge}),
            (Marked{true, false, true, false, true}));
  EXPECT_EQ(run({.source = Source::kConflict, .cause = Cause::kContradiction}),
            (Marked{false, false, true, false, false}));
}

TEST(AmbiguityMasks, PublishedMatchesThatStandOutStandForASurface) {
  const Marked matched{false, true, false, false, false};
  EXPECT_EQ(run({.source = Source::kStereo, .ratio = kNeighbourRatio - 1}), matched);
  EXPECT_EQ(run({.source = Source::kBoth}), matched);
  EXPECT_EQ(run({.source = Source::kResolved, .cause = Cause::kMixedPixel}), matched);
  EXPECT_EQ(run({.source = Source::kResolved, .cause = Cause::kStereoAmbiguous}), Marked{});
  EXPECT_EQ(run({.source = Source::kStereo, .ratio = kNeighbourRatio}), Marked{});
}

TEST(AmbiguityMasks, AWeakMatchCountsWithoutAnother) {
  EXPECT_EQ(run({.disparity = Disparity::none(), .weak = kSome}),
            (Marked{false, false, false, true, false}));
  EXPECT_EQ(run({.weak = kSome}), Marked{});
}

struct Row {
  Row(std::size_t n, test::Random& random)
      : disparity(n), weak(n), ratio(n), flags(n), low(n), high(n), source(n), cause(n) {
    random.fill(ratio.span());
    random.fill(flags.span());
    for (std::size_t x = 0; x < n; ++x) {
      const auto some = [&] {
        return random.between(0, 2) == 0
                   ? Disparity::none()
                   : Disparity::from_raw(static_cast<std::int16_t>(random.next()));
      };
      disparity[x] = some();
      weak[x] = some();
      low[x] = static_cast<QuarterMm>(random.next());
      const int share = low[x] / kNarrowShare + random.between(-2, 2);
      high[x] = static_cast<QuarterMm>(random.between(0, 3) == 0 ? random.between(0, 65535)
                                                                 : std::min(low[x] + share, 65535));
      source[x] = static_cast<Source>(random.between(0, 5));
      cause[x] = static_cast<Cause>(random.between(0, kCauses - 1));
    }
  }
  MaskRow row(bool with_weak) {
    return {disparity.span(),
            with_weak ? weak.span() : std::span<const Disparity>{},
            {ratio.span(), flags.span()},
            {low.span(), high.span()},
            source.span(),
            cause.span()};
  }
  test::GuardedBuffer<Disparity> disparity, weak;
  test::GuardedBuffer<std::uint8_t> ratio, flags;
  test::GuardedBuffer<QuarterMm> low, high;
  test::GuardedBuffer<Source> source;
  test::GuardedBuffer<Cause> cause;
};

struct Words {
  explicit Words(std::size_t n) : open(n), matched(n), disputed(n), weak(n), edge(n) {}
  PixelMasks masks() {
    return {open.span(), matched.span(), disputed.span(), weak.span(), edge.span()};
  }
  test::GuardedBuffer<std::uint64_t> open, matched, disputed, weak, edge;
};

TEST(AmbiguityMasks, AllVectorsEqualTheReferenceForEveryLength) {
  for (const Vectors vectors : test::all_vectors()) {
    const test::UseVectors use(vectors);
    for (std::size_t n = 0; n <= 200; ++n) {
      test::Random random(n);
      Row row(n, random);
      for (const bool with_weak : {false, true}) {
        Words expected((n + 63) / 64);
        Words marked((n + 63) / 64);
        ref::ambiguity_masks(row.row(with_weak), expected.masks());
        best::ambiguity_masks(row.row(with_weak), marked.masks());
        ASSERT_TRUE(std::ranges::equal(expected.open.span(), marked.open.span())) << n;
        ASSERT_TRUE(std::ranges::equal(expected.matched.span(), marked.matched.span())) << n;
        ASSERT_TRUE(std::ranges::equal(expected.disputed.span(), marked.disputed.span())) << n;
        ASSERT_TRUE(std::ranges::equal(expected.weak.span(), marked.weak.span())) << n;
        ASSERT_TRUE(std::ranges::equal(expected.edge.span(), marked.edge.span())) << n;
      }
    }
  }
}

}  // namespace
}  // namespace stof::dsp
