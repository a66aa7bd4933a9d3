#include "dsp/pmd/range/to_quarter_mm.h"

#include <gtest/gtest.h>

#include "dsp/pmd/pmd_maps.h"
#include "dsp/pmd/range/phase_to_distance.h"
#include "tests/support/kernel_check.h"

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
  best::to_quarter_mm({&reading, 1}, unit, {&flags, 1}, {&distance, 1}, {&sigma, 1});
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

TEST(ToQuarterMm, EqualsReferenceForEveryLengthAndExtreme) {
  for (const std::uint32_t unit : {kQuarterMmQ30, kTenthMmQ30, 1U}) {
    for (const int top : {2, 70000, 400000, 2147483647}) {
      test::check_kernel([&](test::KernelCase& c) {
        const std::size_t n = c.length();
        const auto reading = c.array<std::uint32_t>(n, 0, top);
        const auto flags = c.array<std::uint8_t>(n);
        for (std::size_t x = 0; x < n; ++x) {
          reading[x] = c.random().between(0, 9) == 0 ? 0xFFFFFFFF : reading[x];
          flags[x] = c.random().between(0, 3) == 0 ? flags[x] : std::uint8_t{0};
        }
        const auto distance = c.array<QuarterMm>(n), sigma = c.array<QuarterMm>(n);
        c.run([&] { best::to_quarter_mm(reading, unit, flags, distance, sigma); });
      });
    }
  }
}

}  // namespace
}  // namespace stof::dsp
