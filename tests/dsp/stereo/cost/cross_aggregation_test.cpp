#include "dsp/stereo/cost/cross_aggregation.h"

#include <algorithm>
#include <array>
#include <vector>

#include <gtest/gtest.h>

#include "tests/support/kernel_check.h"
#include "tests/support/random.h"

namespace stof::dsp {
namespace {

constexpr int kLanes = 16;

std::size_t at(std::size_t x, int lane) {
  return x * static_cast<std::size_t>(kLanes) + static_cast<std::size_t>(lane);
}

TEST(CrossAggregation, MeansAreThoseOfTheRegionCountedPixelByPixel) {
  constexpr std::size_t kWidth = 9;
  constexpr int kHeight = 6;
  test::Random random(7);
  std::vector<std::vector<std::uint8_t>> costs(kHeight), left(kHeight), right(kHeight);
  std::vector<std::vector<std::uint16_t>> down(kHeight + 1,
                                               std::vector<std::uint16_t>(kWidth * kLanes, 65000));
  std::vector<std::uint16_t> sums((kWidth + 1) * kLanes);
  for (std::size_t y = 0; y < kHeight; ++y) {
    costs[y].resize(kWidth * kLanes);
    random.fill(std::span(costs[y]));
    for (int x = 0; x < static_cast<int>(kWidth); ++x) {
      left[y].push_back(static_cast<std::uint8_t>(random.between(0, std::min(x, 3))));
      right[y].push_back(static_cast<std::uint8_t>(
          random.between(0, std::min(static_cast<int>(kWidth) - 1 - x, 3))));
    }
    best::sum_along(costs[y], kLanes, sums);
    best::sum_down(sums, left[y], right[y], kLanes, down[y], down[y + 1]);
  }
  // Rows 1..4 of column 4.
  std::uint32_t area = 0;
  std::vector<std::uint32_t> expected(kLanes);
  for (std::size_t y = 1; y <= 4; ++y) {
    for (std::size_t x = 4U - left[y][4]; x <= 4U + right[y][4]; ++x, ++area) {
      for (int lane = 0; lane < kLanes; ++lane) {
        expected[static_cast<std::size_t>(lane)] += costs[y][at(x, lane)];
      }
    }
  }
  std::vector<CrossEnds> ends(kWidth, {down[1].data(), down[5].data(), 0});
  ends[4].reciprocal = static_cast<std::int16_t>((65536 + area / 2) / area);
  std::vector<std::uint8_t> means(kWidth * kLanes);
  best::cross_means(ends, kLanes, means);
  for (int lane = 0; lane < kLanes; ++lane) {
    const std::uint32_t sum = expected[static_cast<std::size_t>(lane)];
    EXPECT_NEAR(means[at(4, lane)], static_cast<double>(sum) / area, 0.7) << lane;
    EXPECT_EQ(means[at(3, lane)], 0);  // reciprocal 0
  }
}

TEST(CrossAggregation, ARegionOfTwoPixelsIsTheirMean) {
  const std::vector<std::uint16_t> above(kLanes, 65530);
  std::vector<std::uint16_t> below(kLanes);
  for (int lane = 0; lane < kLanes; ++lane) {
    below[at(0, lane)] = static_cast<std::uint16_t>(65530 + 2 * 17 * lane);
  }
  std::vector<std::uint8_t> means(kLanes);
  best::cross_means(std::vector<CrossEnds>{{above.data(), below.data(), 32767}}, kLanes, means);
  for (int lane = 0; lane < kLanes; ++lane) {
    EXPECT_EQ(means[at(0, lane)], 17 * lane);
  }
}

TEST(CrossAggregation, EqualsReferenceForEveryWidthAndLaneCount) {
  for (const int lanes : {16, 32, 48, 64, 80, 256}) {
    test::check_kernel(
        std::array<std::size_t, 7>{0, 1, 2, 9, 16, 17, 20}, [&](test::KernelCase& c) {
          const std::size_t n = c.length(), step = static_cast<std::size_t>(lanes);
          const auto costs = c.array<std::uint8_t>(n * step, 0, 255);
          const auto left = c.array<std::uint8_t>(n);
          const auto right = c.array<std::uint8_t>(n);
          for (std::size_t x = 0; x < n; ++x) {
            left[x] = static_cast<std::uint8_t>(c.draw(0, static_cast<int>(x)));
            right[x] = static_cast<std::uint8_t>(c.draw(0, static_cast<int>(n - 1 - x)));
          }
          const auto sums = c.array<std::uint16_t>((n + 1) * step);
          c.run([&] { best::sum_along(costs, lanes, sums); });
          const auto above = c.array<std::uint16_t>(n * step);
          const auto below = c.array<std::uint16_t>(n * step);
          c.run([&] { best::sum_down(sums, left, right, lanes, above, below); });
          std::vector<CrossEnds> ends(n);
          for (CrossEnds& end : ends) {
            end = {above.data(), below.data(), static_cast<std::int16_t>(c.draw(0, 32767))};
          }
          const auto means = c.array<std::uint8_t>(n * step);
          c.run([&] { best::cross_means(ends, lanes, means); });
        });
  }
}

}  // namespace
}  // namespace stof::dsp
