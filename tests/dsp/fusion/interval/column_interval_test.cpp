#include "dsp/fusion/interval/column_interval.h"

#include <algorithm>
#include <limits>
#include <vector>

#include <gtest/gtest.h>

#include "tests/support/kernel_check.h"
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
  best::column_interval(disparity, half, tables, low, high);
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

TEST(ColumnInterval, EqualsReferenceForEveryLengthAndAnyDisparity) {
  for (const auto& [first, last] :
       {std::array{0, 0}, {-16, 65 * 16}, {-32768, -32000}, {-700, 300}}) {
    test::check_kernel([&](test::KernelCase& c) {
      const std::size_t n = c.length();
      const std::int64_t numerator =
          (std::int64_t{1} << c.random().between(30, 47)) + c.draw(0, 1 << 20);
      const ColumnTables tables{
          .first_raw = static_cast<std::int16_t>(first),
          .last_raw = static_cast<std::int16_t>(last),
          .max_range = static_cast<QuarterMm>(c.draw(0, 65535)),
          .near_numerator = numerator,
          .far_numerator = numerator + c.random().between(0, 1),
          .left = c.array<std::int32_t>(n, -kOne / 8, kOne / 8),
          .right = c.array<std::int32_t>(right_tangents(n, first, last), -kOne / 8, 3 * kOne)};
      const auto half = c.array<std::uint8_t>(n, 0, 255);
      const auto disparity = c.array<Disparity>(n);
      for (Disparity& d : disparity) {
        const int near =
            std::clamp(first + c.random().between(-2, last - first + 2), -32768, 32767);
        d = c.random().between(0, 3) == 0 ? d
                                          : Disparity::from_raw(static_cast<std::int16_t>(near));
      }
      const auto low = c.array<QuarterMm>(n), high = c.array<QuarterMm>(n);
      c.run([&] { best::column_interval(disparity, half, tables, low, high); });
    });
  }
}

// The quotient is exact: around every multiple of the divisor, for divisors of every size.
TEST(ColumnInterval, EqualsReferenceAtTheEdgesOfEveryQuotient) {
  constexpr std::size_t kColumns = 64;
  constexpr std::size_t kSeeds = 40;
  test::check_kernel_rounds(31 * kSeeds, [](test::KernelCase& c) {
    test::Random& random = c.random();
    const std::size_t seed = c.length() % kSeeds;
    const std::int64_t low_divisor = std::int64_t{1} << (c.length() / kSeeds);
    const std::int64_t more =
        static_cast<std::int64_t>(random.next() % static_cast<std::uint64_t>(low_divisor));
    const std::int64_t divisor = seed == 0 ? low_divisor : low_divisor + more;
    const int quotient = seed < 4 ? 65535 - static_cast<int>(seed) : random.between(1, 65535);
    const std::int64_t numerator =
        std::max(divisor * quotient + random.between(-2, 2), std::int64_t{1} << 30);
    const auto left = c.array<std::int32_t>(kColumns);
    const auto right = c.array<std::int32_t>(right_tangents(kColumns, 0, 0), 0, 0);
    for (std::size_t x = 0; x < kColumns; ++x) {
      const std::int64_t difference =
          std::clamp<std::int64_t>(divisor + static_cast<std::int64_t>(x) - 32, -4,
                                   std::numeric_limits<std::int32_t>::max() - 1);
      left[x] = static_cast<std::int32_t>(-(difference / 2));
      right[x * Disparity::kOne + kMostHalfWidth] =
          static_cast<std::int32_t>(difference - difference / 2);
    }
    const ColumnTables tables{
        .max_range = static_cast<QuarterMm>(seed % 2 == 0 ? 65535 : random.between(1, 65535)),
        .near_numerator = numerator,
        .far_numerator = numerator,
        .left = left,
        .right = right};
    const auto disparity = c.array<Disparity>(kColumns);
    std::ranges::fill(disparity, Disparity::from_raw(0));
    const auto half = c.array<std::uint8_t>(kColumns, 0, 0);
    const auto low = c.array<QuarterMm>(kColumns), high = c.array<QuarterMm>(kColumns);
    c.run([&] { best::column_interval(disparity, half, tables, low, high); });
  });
}

}  // namespace
}  // namespace stof::dsp
