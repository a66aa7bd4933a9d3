#include "dsp/fusion/project/paint.h"

#include <algorithm>
#include <array>
#include <vector>

#include <gtest/gtest.h>

#include "tests/support/guarded.h"
#include "tests/support/random.h"

namespace stof::dsp {
namespace {

TEST(VisibleBehind, IsTwoPercentAndNeverHidesASurfaceFromItself) {
  for (std::uint32_t depth = 1; depth <= 65535; ++depth) {
    const std::uint32_t nearest = visible_behind(static_cast<QuarterMm>(depth));
    ASSERT_LE(nearest, depth);
    ASSERT_LE(50 * depth, 51 * nearest) << depth;        // within 2 percent
    ASSERT_GT(50 * depth, 51 * (nearest - 1)) << depth;  // one less is not
  }
}

TEST(Paint, UnitesWithinTwoPercentAndHidesWhatIsFarther) {
  std::array<QuarterMm, 3> nearest{1000, 981, 980};
  std::array<QuarterMm, 3> low{950, 950, 950};
  std::array<QuarterMm, 3> high{1050, 1050, 1050};
  std::array<std::uint8_t, 3> flags{1, 1, 1};
  ref::paint_interval({visible_behind(1000), 900, 1100, 32}, nearest, low, high, flags);
  EXPECT_EQ(low, (std::array<QuarterMm, 3>{900, 900, 950}));
  EXPECT_EQ(high, (std::array<QuarterMm, 3>{1100, 1100, 1050}));
  EXPECT_EQ(flags, (std::array<std::uint8_t, 3>{33, 33, 1}));
}

TEST(Paint, StaysInTheFootprintAndInTheRows) {
  std::array<QuarterMm, 12> nearest{};
  nearest.fill(985);
  const Footprint footprint{1, 3, 0, 2, 980, {visible_behind(980), 900, 1100, 32}};
  const ImageView<QuarterMm> image(nearest.data(), 4, 3);
  ref::paint_nearest({&footprint, 1}, {1, 3}, image);
  EXPECT_EQ(nearest, (std::array<QuarterMm, 12>{985, 985, 985, 985, 985, 980, 980, 985, 985, 985,
                                                985, 985}));
  std::array<QuarterMm, 12> low{};
  low.fill(kNothingPainted);
  std::array<QuarterMm, 12> high{};
  std::array<std::uint8_t, 12> flags{};
  ref::paint_intervals({&footprint, 1}, {1, 3},
                       {image, {low.data(), 4, 3}, {high.data(), 4, 3}, {flags.data(), 4, 3}});
  EXPECT_EQ(high, (std::array<QuarterMm, 12>{0, 0, 0, 0, 0, 1100, 1100, 0, 0, 0, 0, 0}));
  EXPECT_EQ(flags, (std::array<std::uint8_t, 12>{0, 0, 0, 0, 0, 32, 32, 0, 0, 0, 0, 0}));
  EXPECT_EQ(low[5], 900);
  EXPECT_EQ(low[4], kNothingPainted);
}

// Images before and after, with gaps between their rows.
struct Images {
  Images(int width, int height, int stride)
      : nearest(width, height, stride, 9),
        low(width, height, stride, 9),
        high(width, height, stride, 9),
        flags(width, height, stride, 9) {}
  PaintedView view() { return {nearest.view(), low.view(), high.view(), flags.view()}; }
  void fill(std::uint64_t seed) {
    test::Random random(seed);
    for (int y = 0; y < nearest.view().height(); ++y) {
      random.fill(nearest.view().row(y));
      random.fill(low.view().row(y));
      random.fill(high.view().row(y));
      random.fill(flags.view().row(y));
      for (QuarterMm& depth : nearest.view().row(y)) {
        depth = random.between(0, 4) == 0 ? kNothingPainted : depth;
      }
    }
  }
  bool padding_untouched() {
    return nearest.padding_is(9) && low.padding_is(9) && high.padding_is(9) && flags.padding_is(9);
  }
  bool same(Images& other) {
    bool equal = true;
    for (int y = 0; y < nearest.view().height(); ++y) {
      equal = equal && std::ranges::equal(nearest.view().row(y), other.nearest.view().row(y)) &&
              std::ranges::equal(low.view().row(y), other.low.view().row(y)) &&
              std::ranges::equal(high.view().row(y), other.high.view().row(y)) &&
              std::ranges::equal(flags.view().row(y), other.flags.view().row(y));
    }
    return equal;
  }
  test::GuardedImage<QuarterMm> nearest, low, high;
  test::GuardedImage<std::uint8_t> flags;
};

std::vector<Footprint> footprints_in(int width, int height, std::uint64_t seed) {
  test::Random random(seed);
  std::vector<Footprint> footprints;
  for (int k = random.between(0, 6); k > 0; --k) {
    const int x = random.between(0, width - 1);
    const int y = random.between(0, height - 1);
    const int x_end = random.between(0, 3) == 0 ? width : random.between(x + 1, width);
    const auto depth = static_cast<QuarterMm>(random.next());
    footprints.push_back({.x_begin = static_cast<std::int16_t>(x),
                          .x_end = static_cast<std::int16_t>(x_end),
                          .y_begin = static_cast<std::int16_t>(y),
                          .y_end = static_cast<std::int16_t>(random.between(y + 1, height)),
                          .depth = depth,
                          .paint = {.visible = visible_behind(depth),
                                    .low = static_cast<QuarterMm>(random.next()),
                                    .high = static_cast<QuarterMm>(random.next()),
                                    .flags = static_cast<std::uint8_t>(random.next())}});
  }
  return footprints;
}

TEST(Paint, NeonEqualsReferenceForFootprintsOfEverySize) {
  for (int width = 1; width <= 40; ++width) {
    for (std::uint64_t round = 0; round < 20; ++round) {
      const std::uint64_t seed = static_cast<std::uint64_t>(width) * 20 + round;
      test::Random random(seed);
      const int height = random.between(1, 9);
      const std::vector<Footprint> footprints = footprints_in(width, height, seed);
      const Rows rows{random.between(0, height - 1), height - random.between(0, height) / 2};
      Images a(width, height, width + random.between(0, 3));
      Images b(width, height, width + random.between(0, 3));
      a.fill(seed);
      b.fill(seed);
      ref::paint_intervals(footprints, rows, a.view());
      neon::paint_intervals(footprints, rows, b.view());
      ASSERT_TRUE(a.same(b)) << "seed " << seed;
      ref::paint_nearest(footprints, rows, a.nearest.view());
      neon::paint_nearest(footprints, rows, b.nearest.view());
      ASSERT_TRUE(a.same(b)) << "seed " << seed;
      ASSERT_TRUE(b.padding_untouched()) << "seed " << seed;
    }
  }
}

TEST(Paint, NeonEqualsReferenceForSegmentsOfEveryLength) {
  for (std::size_t n = 0; n <= 70; ++n) {
    test::Random random(n);
    test::GuardedBuffer<QuarterMm> nearest_a(n), low_a(n), high_a(n), nearest_b(n), low_b(n),
        high_b(n);
    test::GuardedBuffer<std::uint8_t> flags_a(n), flags_b(n);
    random.fill(nearest_a.span());
    random.fill(low_a.span());
    random.fill(high_a.span());
    random.fill(flags_a.span());
    for (std::size_t x = 0; x < n; ++x) {
      nearest_a[x] = random.between(0, 4) == 0 ? kNothingPainted : nearest_a[x];
      nearest_b[x] = nearest_a[x];
      low_b[x] = low_a[x];
      high_b[x] = high_a[x];
      flags_b[x] = flags_a[x];
    }
    for (const QuarterMm depth : {QuarterMm{0}, QuarterMm{30000}, kMaxQuarterMm}) {
      const Paint paint{depth, static_cast<QuarterMm>(random.next()),
                        static_cast<QuarterMm>(random.next()),
                        static_cast<std::uint8_t>(random.next())};
      ref::paint_interval(paint, nearest_a.span(), low_a.span(), high_a.span(), flags_a.span());
      neon::paint_interval(paint, nearest_b.span(), low_b.span(), high_b.span(), flags_b.span());
      ASSERT_TRUE(std::ranges::equal(low_a.span(), low_b.span())) << n;
      ASSERT_TRUE(std::ranges::equal(high_a.span(), high_b.span())) << n;
      ASSERT_TRUE(std::ranges::equal(flags_a.span(), flags_b.span())) << n;
    }
  }
}

}  // namespace
}  // namespace stof::dsp
