#include "dsp/fusion/interval/column_interval.h"

#include <algorithm>
#include <limits>
#include <vector>

#include <gtest/gtest.h>

#include "tests/support/guarded.h"
#include "tests/support/random.h"

namespace stof::dsp {
namespace {

constexpr std::int32_t kOne = 1 << kTangentBits;

struct Interval {
  int low = 0;
  int high = 0;
  friend bool operator==(const Interval&, const Interval&) = default;
};

// One pixel at column 0 with the same T_r for both ends.
Interval interval_of(std::int32_t right, std::int32_t left, std::int64_t numerator,
                     QuarterMm max_range = 40000) {
  const std::vector<std::int32_t> lefts{left};
  const std::vector<std::int32_t> rights(right_tangents(1, 0, 0), right);
  const ColumnTables tables{.max_range = max_range,
                            .near_numerator = numerator,
                            .far_numerator = numerator,
                            .left = lefts,
                            .right = rights};
  const std::vector<Disparity> disparity{Disparity::from_raw(0)};
  const std::vector<std::uint8_t> half{0};
  std::vector<QuarterMm> low{7}, high{7};
  ref::column_interval(disparity, half, tables, low, high);
  return {low[0], high[0]};
}

TEST(ColumnInterval, DividesTheBaselineByTheDifferenceOfTangents) {
  // b = 0.2 m = 800 quarter mm. A tenth: 2 m; the ends of 8000 are one unit of Q28 away.
  const std::int64_t b = std::int64_t{800} << kTangentBits;
  EXPECT_EQ(interval_of(kOne / 10, 0, b), (Interval{7999, 8001}));
  EXPECT_EQ(interval_of(kOne / 2, kOne / 4, b), (Interval{3199, 3201}));
  EXPECT_EQ(interval_of(-kOne / 4, -kOne / 2, b), (Interval{3199, 3201}));
}

TEST(ColumnInterval, EndsAtTheLargestRangeAndBehindInfinity) {
  const std::int64_t b = std::int64_t{800} << kTangentBits;
  EXPECT_EQ(interval_of(kOne / 50, 0, b), (Interval{39999, 40000}));
  EXPECT_EQ(interval_of(kOne / 51, 0, b), (Interval{}));
  EXPECT_EQ(interval_of(5, 5, b), (Interval{}));                // parallel
  EXPECT_EQ(interval_of(5, 6, b), (Interval{}));                // they part
  EXPECT_EQ(interval_of(5, 5, b, 65535), (Interval{}));         // one unit of slack: far away
  EXPECT_EQ(interval_of(kOne / 10, 0, b, 0), (Interval{}));     // no range at all
  EXPECT_EQ(interval_of(kOne / 10, 0, b, 7999), (Interval{}));  // begins where the range ends
  EXPECT_EQ(interval_of(kOne / 10, 0, b, 8000), (Interval{7999, 8000}));
}

TEST(ColumnInterval, IsAtLeastOneUnitAway) {
  const std::int64_t b = std::int64_t{4} << kTangentBits;  // 1 mm
  EXPECT_EQ(interval_of(3 * kOne, -3 * kOne, b), (Interval{1, 1}));
}

TEST(ColumnInterval, OfAColumnWithoutRayIsNone) {
  const std::int64_t b = std::int64_t{800} << kTangentBits;
  for (const std::int32_t other : {-4 * (kOne - 1), -kOne, 0, kOne, 4 * (kOne - 1)}) {
    EXPECT_EQ(interval_of(kNoRightRay, other, b), (Interval{})) << other;
    EXPECT_EQ(interval_of(other, kNoLeftRay, b), (Interval{})) << other;
  }
  EXPECT_EQ(interval_of(kNoRightRay, kNoLeftRay, b), (Interval{}));
}

// Tables, disparities and results of one row, ending at unreadable pages.
struct Row {
  Row(std::size_t n, int first, int last)
      : left(n),
        right(right_tangents(n, first, last)),
        disparity(n),
        half(n),
        tables{.first_raw = static_cast<std::int16_t>(first),
               .last_raw = static_cast<std::int16_t>(last),
               .left = left.span(),
               .right = right.span()} {}

  void expect_equal(const char* what) {
    test::GuardedBuffer<QuarterMm> low_a(left.size()), low_b(left.size()), high_a(left.size()),
        high_b(left.size());
    ref::column_interval(disparity.span(), half.span(), tables, low_a.span(), high_a.span());
    neon::column_interval(disparity.span(), half.span(), tables, low_b.span(), high_b.span());
    ASSERT_TRUE(std::ranges::equal(low_a.span(), low_b.span())) << what;
    ASSERT_TRUE(std::ranges::equal(high_a.span(), high_b.span())) << what;
  }

  test::GuardedBuffer<std::int32_t> left, right;
  test::GuardedBuffer<Disparity> disparity;
  test::GuardedBuffer<std::uint8_t> half;
  ColumnTables tables;
};

TEST(ColumnInterval, NeonEqualsReferenceForEveryLengthAndAnyDisparity) {
  for (std::size_t n = 0; n <= 40; ++n) {
    for (const auto& [first, last] :
         {std::array{0, 0}, {-16, 65 * 16}, {-32768, -32000}, {-700, 300}}) {
      Row row(n, first, last);
      test::Random random(n + static_cast<std::size_t>(last + 40000));
      row.tables.max_range = static_cast<QuarterMm>(random.between(0, 65535));
      row.tables.near_numerator =
          (std::int64_t{1} << random.between(30, 47)) + random.between(0, 1 << 20);
      row.tables.far_numerator = row.tables.near_numerator + random.between(0, 1);
      random.fill(row.half.span());
      random.fill(row.left.span(), -kOne / 8, kOne / 8);
      random.fill(row.right.span(), -kOne / 8, 3 * kOne);
      for (Disparity& d : row.disparity.span()) {
        const int raw =
            random.between(0, 3) == 0
                ? random.between(-32768, 32767)
                : std::clamp(first + random.between(-2, last - first + 2), -32768, 32767);
        d = Disparity::from_raw(static_cast<std::int16_t>(raw));
      }
      row.expect_equal("random");
    }
  }
}

// The quotient is exact: around every multiple of the divisor, for divisors of every size.
TEST(ColumnInterval, NeonEqualsReferenceAtTheEdgesOfEveryQuotient) {
  constexpr std::size_t kColumns = 64;
  for (int bits = 0; bits < 31; ++bits) {
    for (int seed = 0; seed < 40; ++seed) {
      test::Random random(static_cast<std::uint64_t>(100 * bits + seed));
      Row row(kColumns, 0, 0);
      std::ranges::fill(row.half.span(), std::uint8_t{0});
      row.tables.max_range =
          static_cast<QuarterMm>(seed % 2 == 0 ? 65535 : random.between(1, 65535));
      const std::int64_t low = std::int64_t{1} << bits;
      const std::int64_t divisor =
          seed == 0
              ? low
              : low + static_cast<std::int64_t>(random.next() % static_cast<std::uint64_t>(low));
      const int quotient = seed < 4 ? 65535 - seed : random.between(1, 65535);
      const std::int64_t numerator =
          std::max(divisor * quotient + random.between(-2, 2), std::int64_t{1} << 30);
      row.tables.near_numerator = numerator;
      row.tables.far_numerator = numerator;
      for (std::size_t x = 0; x < kColumns; ++x) {
        const std::int64_t difference =
            std::clamp<std::int64_t>(divisor + static_cast<std::int64_t>(x) - 32, -4,
                                     std::numeric_limits<std::int32_t>::max() - 1);
        row.left[x] = static_cast<std::int32_t>(-(difference / 2));
        row.right[x * Disparity::kOne + kMostSpread] =
            static_cast<std::int32_t>(difference - difference / 2);
        row.disparity[x] = Disparity::from_raw(0);
      }
      row.expect_equal("edge");
    }
  }
}

}  // namespace
}  // namespace stof::dsp
