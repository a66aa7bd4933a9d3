#include "dsp/stereo/cost/cross_aggregation.h"

#include <array>
#include <vector>

#include <gtest/gtest.h>

#include "tests/support/kernel_check.h"

namespace stof::dsp {
namespace {

constexpr int kLanes = 16;
using Bytes = std::vector<std::uint8_t>;

Bytes lanes_of(std::initializer_list<int> columns) {
  Bytes all;
  for (const int value : columns) {
    all.insert(all.end(), kLanes, static_cast<std::uint8_t>(value));
  }
  return all;
}

TEST(CrossAggregation, SumsReachTheNeighboursThatAreJoined) {
  const Bytes costs = lanes_of({1, 2, 4, 8});
  Bytes sums(costs.size());
  best::sum_alike(costs, Bytes{0, 1, 0, 1, 0}, kLanes, sums);
  EXPECT_EQ(sums, lanes_of({3, 3, 12, 12}));
  best::sum_alike(costs, Bytes{0, 1, 1, 1, 0}, kLanes, sums);
  EXPECT_EQ(sums, lanes_of({3, 7, 14, 12}));
}

TEST(CrossAggregation, LargestCostsFit) {
  const Bytes costs =
      lanes_of({kLargestAggregatedInput, kLargestAggregatedInput, kLargestAggregatedInput});
  Bytes sums(costs.size()), means(costs.size());
  best::sum_alike(costs, Bytes{0, 1, 1, 0}, kLanes, sums);
  EXPECT_EQ(sums, lanes_of({170, 255, 170}));
  const Bytes ones(3, 1);
  best::cross_means({.above = sums,
                     .here = sums,
                     .below = sums,
                     .with_above = ones,
                     .with_below = ones,
                     .areas = ones,
                     .reciprocals = std::array<std::int16_t, 2>{0, 32767}},
                    kLanes, means);
  EXPECT_EQ(means, Bytes(costs.size(), 255));
}

TEST(CrossAggregation, MeansAreSumsTimesTheReciprocalRounded) {
  const Bytes here = lanes_of({45, 45, 45}), beside = lanes_of({33, 33, 33});
  Bytes means(here.size());
  const auto of = [](int pixels) {
    return static_cast<std::int16_t>((32768 + pixels / 2) / pixels);
  };
  best::cross_means({.above = beside,
                     .here = here,
                     .below = beside,
                     .with_above = Bytes{0, 1, 1},
                     .with_below = Bytes{0, 0, 1},
                     .areas = Bytes{0, 1, 2},
                     .reciprocals = std::array{of(2), of(6), of(9)}},
                    kLanes, means);
  EXPECT_EQ(means, lanes_of({23, 13, 12}));  // 22.5, 13, 12.33
}

TEST(CrossAggregation, EqualsReferenceForEveryWidthAndLaneCount) {
  for (const int lanes : {16, 32, 48, 64, 80, 256}) {
    test::check_kernel(
        std::array<std::size_t, 7>{0, 1, 2, 9, 16, 17, 20}, [&](test::KernelCase& c) {
          const std::size_t n = c.length(), step = static_cast<std::size_t>(lanes);
          const auto costs = c.array<std::uint8_t>(n * step, 0, kLargestAggregatedInput);
          const auto joined = c.array<std::uint8_t>(n + 1, 0, 1);
          joined.front() = joined.back() = 0;
          const auto sums = c.array<std::uint8_t>(n * step);
          c.run([&] { best::sum_alike(costs, joined, lanes, sums); });
          const auto above = c.array<std::uint8_t>(n * step, 0, 255);
          const auto below = c.array<std::uint8_t>(n * step, 0, 255);
          const auto with_above = c.array<std::uint8_t>(n, 0, 1);
          const auto with_below = c.array<std::uint8_t>(n, 0, 1);
          const auto areas = c.array<std::uint8_t>(n, 0, 9);
          const auto reciprocals = c.array<std::int16_t>(10, 0, 32767);
          const auto means = c.array<std::uint8_t>(n * step);
          c.run([&] {
            best::cross_means({above, sums, below, with_above, with_below, areas, reciprocals},
                              lanes, means);
          });
        });
  }
}

}  // namespace
}  // namespace stof::dsp
