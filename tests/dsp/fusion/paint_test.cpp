#include "dsp/fusion/paint.h"

#include <algorithm>
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
  ref::paint_nearest(985, nearest);
  EXPECT_EQ(nearest, (std::array<QuarterMm, 3>{985, 981, 980}));
}

TEST(Paint, NeonEqualsReferenceForEveryLength) {
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
    ref::paint_nearest(30000, nearest_a.span());
    neon::paint_nearest(30000, nearest_b.span());
    ASSERT_TRUE(std::ranges::equal(nearest_a.span(), nearest_b.span())) << n;
  }
}

}  // namespace
}  // namespace stof::dsp
