#include "dsp/pmd/interval/average_pairs.h"

#include <array>
#include <cmath>

#include <gtest/gtest.h>

#include "tests/support/kernel_check.h"

namespace stof::dsp {
namespace {

using Block = std::array<QuarterMm, 9>;

struct Mean {
  int distance;
  int sigma;
  friend bool operator==(const Mean&, const Mean&) = default;
};

// Of the middle of 3x3 readings, row by row.
Mean mean_of(const Block& distance, const Block& sigma, std::uint16_t slope_q16 = 0) {
  const auto row = [](const Block& block, std::size_t y) {
    return std::span(block).subspan(3 * y, 3);
  };
  QuarterMm d = 7;
  QuarterMm s = 7;
  best::average_pairs({row(distance, 0), row(distance, 1), row(distance, 2), row(sigma, 0),
                       row(sigma, 1), row(sigma, 2)},
                      slope_q16, {&d, 1}, {&s, 1});
  return {d, s};
}

Block all(QuarterMm value) {
  Block block;
  block.fill(value);
  return block;
}

TEST(AveragePairs, NineReadingsOfAWallHaveAboutHalfTheNoise) {
  const Mean mean = mean_of({8010, 7990, 8010, 7990, 8030, 8010, 7990, 8010, 7990}, all(60));
  EXPECT_NEAR(mean.distance, 8003, 1);
  EXPECT_EQ(mean.sigma, 28);  // 1.4 * 60 / 3
}

TEST(AveragePairs, ASlopeStaysAsItIs) {
  // 2000 steps a pixel, 500 a row: far more than noise.
  const Block slope{7500, 9500, 11500, 8000, 10000, 12000, 8500, 10500, 12500};
  EXPECT_EQ(mean_of(slope, all(60), 60000), (Mean{10000, 28}));
  EXPECT_EQ(mean_of(slope, all(60)), (Mean{10000, 60}));  // each pair is a step
}

TEST(AveragePairs, NothingIsAveragedAcrossAStep) {
  const Block step{8000, 8000, 12000, 8000, 8000, 12000, 8000, 8000, 12000};
  const Mean mean = mean_of(step, all(60), 9830);
  EXPECT_EQ(mean.distance, 8000);
  EXPECT_EQ(mean.sigma, 48);  // 1.4 * 60 / sqrt(3): the pair above and below
}

TEST(AveragePairs, ALonelyReadingStaysAndAMissingOneStaysMissing) {
  Block distance = all(0);
  Block sigma = all(0);
  EXPECT_EQ(mean_of(distance, sigma), (Mean{0, 0}));
  distance[4] = 9000;
  sigma[4] = 300;
  EXPECT_EQ(mean_of(distance, sigma), (Mean{9000, 300}));
  distance.fill(9000);
  sigma.fill(kMaxAveragedSigma + 1);  // too noisy for a mean to mean anything
  EXPECT_EQ(mean_of(distance, sigma), (Mean{9000, kMaxAveragedSigma + 1}));
}

TEST(AveragePairs, SharesAreThoseOfAMean) {
  for (std::size_t p = 0; p < kSmoothShare.size(); ++p) {
    const double readings = 1 + 2 * static_cast<double>(p);
    EXPECT_NEAR(kSmoothShare[p], 32768 * std::min(1.4 / std::sqrt(readings), 1.0), 0.5);
    EXPECT_NEAR(kPairShare[p], p == 0 ? 0 : 32768 * 2 / readings, 0.5);
  }
}

TEST(AveragePairs, EqualsReference) {
  test::check_kernel([](test::KernelCase& c) {
    const std::size_t n = c.length();
    const std::array<int, 4> spreads{300, 3000, 20000, 65535};
    const int base = c.draw(0, 3) == 0 ? 0 : 12000;
    const int spread = spreads[static_cast<std::size_t>(c.random().between(0, 3))];
    const int noise = c.random().between(0, 3) == 0 ? 65535 : 200;
    IntervalRows rows;
    for (std::span<const QuarterMm>* row :
         {&rows.distance_above, &rows.distance_here, &rows.distance_below}) {
      const std::span<QuarterMm> values =
          c.array<QuarterMm>(n + 2, base, std::min(base + spread, 65535));
      for (QuarterMm& value : values) {
        value = c.random().between(0, 8) == 0 ? kNoDepth : value;
      }
      *row = values;
    }
    rows.sigma_above = c.array<QuarterMm>(n + 2, 0, noise);
    rows.sigma_here = c.array<QuarterMm>(n + 2, 0, noise);
    rows.sigma_below = c.array<QuarterMm>(n + 2, 0, noise);
    const std::uint16_t slope = static_cast<std::uint16_t>(c.draw(0, 65535));
    const std::span<QuarterMm> distance = c.array<QuarterMm>(n);
    const std::span<QuarterMm> sigma = c.array<QuarterMm>(n);
    c.run([&] { best::average_pairs(rows, slope, distance, sigma); });
  });
}

}  // namespace
}  // namespace stof::dsp
