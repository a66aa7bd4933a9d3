#include "dsp/stereo/cost/ad_census.h"

#include <vector>

#include <gtest/gtest.h>

#include "dsp/stereo/cost/census.h"
#include "tests/support/kernel_check.h"

namespace stof::dsp {
namespace {

constexpr int kLargestByte = (1 << kPlaneBits) - 1;

constexpr std::size_t kPlanes = planes_of(kCensus7x7.bits());

TEST(AdCensusCosts, AreTwiceTheHammingDistanceAndHalfTheClippedDifferences) {
  const std::vector<std::uint8_t> no_bits(kPlanes, 0);
  std::vector<std::uint8_t> planes(kPlanes * 16, 0);
  planes[3] = 0b0111;  // candidate 3: three bits
  std::vector<std::uint8_t> grey(16, 100);
  grey[1] = 95;   // 5 levels: 5 / 2 = 2
  grey[2] = 255;  // clipped at 24: 12
  grey[4] = 101;
  std::vector<std::uint8_t> derivative(16, 20);
  derivative[4] = 19;  // with the grey level 2 / 2 = 1
  derivative[5] = 0;   // 10
  derivative[6] = 41;  // clipped at 20: 10
  const std::vector<std::uint8_t> own_grey{100}, own_derivative{20};
  std::vector<std::uint8_t> costs(16, 99);
  best::ad_census_costs({no_bits, own_grey, own_derivative}, {planes, grey, derivative}, 16, costs);
  EXPECT_EQ(costs, (std::vector<std::uint8_t>{0, 2, 12, 6, 1, 10, 10, 0, 0, 0, 0, 0, 0, 0, 0, 0}));
}

TEST(AdCensusCosts, StayWithinTheBoundThatSumsAreSizedBy) {
  const std::vector<std::uint8_t> zeros(kPlanes, 0), black{0};
  const std::vector<std::uint8_t> white(16, 255);
  std::vector<std::uint8_t> ones(kPlanes * 16, kLargestByte);
  std::vector<std::uint8_t> costs(16);
  best::ad_census_costs({zeros, black, black}, {ones, white, white}, 16, costs);
  EXPECT_EQ(costs, std::vector<std::uint8_t>(16, kLargestAdCensusCost));
}

TEST(AdCensusCosts, EqualReferenceForEveryShape) {
  for (const int lanes : {16, 48, 64, 80, 128, 256}) {
    test::check_kernel(std::span(test::kHostileLengths).subspan(1), [&](test::KernelCase& c) {
      const std::size_t n = c.length(), right = n + static_cast<std::size_t>(lanes) - 1;
      const AdCensusRow left_row{c.array<std::uint8_t>(kPlanes * n, 0, kLargestByte),
                                 c.array<std::uint8_t>(n, 0, 255), c.array<std::uint8_t>(n, 0, 40)};
      const AdCensusRow right_row{c.array<std::uint8_t>(kPlanes * right, 0, kLargestByte),
                                  c.array<std::uint8_t>(right, 0, 255),
                                  c.array<std::uint8_t>(right, 0, 40)};
      const auto costs = c.array<std::uint8_t>(n * static_cast<std::size_t>(lanes));
      c.run([&] { best::ad_census_costs(left_row, right_row, lanes, costs); });
    });
  }
}

}  // namespace
}  // namespace stof::dsp
