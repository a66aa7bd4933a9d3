#include "dsp/pmd/range/to_quarter_mm.h"

#include <algorithm>

#include <gtest/gtest.h>

#include "dsp/pmd/pmd_maps.h"
#include "dsp/pmd/range/range.h"
#include "tests/support/guarded.h"
#include "tests/support/random.h"

namespace stof::dsp {
namespace {

struct Published {
  std::uint32_t reading;
  int distance;
  int sigma;
  int flags;
  friend bool operator==(const Published&, const Published&) = default;
};

Published run(std::uint32_t reading, std::uint32_t unit, std::uint8_t flags = 0) {
  QuarterMm distance = 7;
  QuarterMm sigma = 40;
  ref::to_quarter_mm({&reading, 1}, unit, {&flags, 1}, {&distance, 1}, {&sigma, 1});
  return {reading, distance, sigma, flags};
}

TEST(ToQuarterMm, KeepsQuarterMillimetresAsTheyAre) {
  for (const int d : {1, 2, 8000, 65535}) {
    EXPECT_EQ(run(static_cast<std::uint32_t>(d), kQuarterMmQ30),
              (Published{static_cast<std::uint32_t>(d), d, 40, 0}));
  }
}

TEST(ToQuarterMm, WritesAMeasuredZeroAsOneBecauseZeroMeansNone) {
  EXPECT_EQ(run(0, kQuarterMmQ30), (Published{1, 1, 40, 0}));
  EXPECT_EQ(run(0, kTenthMmQ30), (Published{1, 1, 40, 0}));
}

TEST(ToQuarterMm, RoundsTenthsOfAMillimetre) {
  for (std::uint32_t d = 3; d < 163837; d += 7) {
    EXPECT_EQ(run(d, kTenthMmQ30).distance, static_cast<int>((4 * d + 5) / 10)) << d;
  }
}

TEST(ToQuarterMm, LeavesToTheLongRangeWhatSixteenBitsDoNotHold) {
  EXPECT_EQ(run(163838, kTenthMmQ30), (Published{163838, 65535, 40, 0}));
  EXPECT_EQ(run(163839, kTenthMmQ30), (Published{163839, 0, 0, kPmdOutOfRange}));
  EXPECT_EQ(run(65536, kQuarterMmQ30), (Published{65536, 0, 0, kPmdOutOfRange}));
  EXPECT_EQ(run(0xFFFFFFFF, kTenthMmQ30), (Published{kMostUnits, 0, 0, kPmdOutOfRange}));
}

TEST(ToQuarterMm, LeavesOutPixelsThatAreNotToBeTrusted) {
  for (int bit = 0; bit < 8; ++bit) {
    const std::uint8_t flag = static_cast<std::uint8_t>(1 << bit);
    const bool missing = (flag & kPmdMissing) != 0;
    EXPECT_EQ(run(20000, kQuarterMmQ30, flag) == (Published{0, 0, 0, flag}), missing) << bit;
    EXPECT_EQ(run(200000, kQuarterMmQ30, flag) == (Published{0, 0, 0, flag}), missing) << bit;
  }
}

TEST(ToQuarterMm, NeonEqualsReferenceForEveryLengthAndExtreme) {
  for (std::size_t n = 0; n <= 70; ++n) {
    for (const std::uint32_t unit : {kQuarterMmQ30, kTenthMmQ30, 1U}) {
      for (const int top : {2, 70000, 400000, 2147483647}) {
        test::Random random(n + unit + static_cast<std::uint64_t>(top));
        test::GuardedBuffer<std::uint32_t> reading_a(n), reading_b(n);
        test::GuardedBuffer<std::uint8_t> flags_a(n), flags_b(n);
        test::GuardedBuffer<QuarterMm> distance_a(n), distance_b(n), sigma_a(n), sigma_b(n);
        for (std::size_t x = 0; x < n; ++x) {
          const bool extreme = random.between(0, 9) == 0;
          reading_a[x] = extreme ? 0xFFFFFFFF : static_cast<std::uint32_t>(random.between(0, top));
          reading_b[x] = reading_a[x];
          flags_a[x] = random.between(0, 3) == 0 ? static_cast<std::uint8_t>(random.next()) : 0;
          flags_b[x] = flags_a[x];
          sigma_a[x] = static_cast<QuarterMm>(random.next());
          sigma_b[x] = sigma_a[x];
        }
        ref::to_quarter_mm(reading_a.span(), unit, flags_a.span(), distance_a.span(),
                           sigma_a.span());
        neon::to_quarter_mm(reading_b.span(), unit, flags_b.span(), distance_b.span(),
                            sigma_b.span());
        ASSERT_TRUE(std::ranges::equal(reading_a.span(), reading_b.span())) << n << " top " << top;
        ASSERT_TRUE(std::ranges::equal(flags_a.span(), flags_b.span())) << n << " top " << top;
        ASSERT_TRUE(std::ranges::equal(distance_a.span(), distance_b.span()))
            << n << " top " << top;
        ASSERT_TRUE(std::ranges::equal(sigma_a.span(), sigma_b.span())) << n << " top " << top;
      }
    }
  }
}

}  // namespace
}  // namespace stof::dsp
