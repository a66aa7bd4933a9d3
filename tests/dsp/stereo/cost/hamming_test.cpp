#include "dsp/stereo/cost/hamming.h"

#include <algorithm>
#include <array>
#include <vector>

#include <gtest/gtest.h>

#include "dsp/stereo/cost/census.h"
#include "tests/support/kernel_check.h"

namespace stof::dsp {
namespace {

TEST(HammingCosts, CountsTheBitsInWhichAColumnAndItsCandidateDiffer) {
  // Two columns, 16 lanes: column 1 meets candidate i at element i, column 0 at element i + 1.
  constexpr std::size_t kPlanes = planes_of(kCensus5x5.bits());
  std::vector<std::uint8_t> left(kPlanes * 2, 0), right(kPlanes * 17, 0);
  left[1] = 0b1111;        // plane 0 of column 1
  left[2] = 0b0101;        // plane 1 of column 0
  right[1] = 0b0011;       // plane 0 of candidate 0 of column 0, candidate 1 of column 1
  right[17 + 1] = 0b0001;  // plane 1
  right.back() = 0b0001;   // last plane of candidate 15 of column 0
  std::vector<std::uint8_t> costs(32, 99);
  best::hamming_costs(left, right, kCensus5x5.bits(), 16, costs);
  EXPECT_EQ(costs[0], 2 + 1);  // 0000 ^ 0011, 0101 ^ 0001
  EXPECT_EQ(costs[1], 0 + 2);  // 0000 ^ 0000, 0101 ^ 0000
  EXPECT_EQ(costs[15], 0 + 2 + 1);
  EXPECT_EQ(costs[16], 4 + 0);      // 1111 ^ 0000, 0000 ^ 0000
  EXPECT_EQ(costs[16 + 1], 2 + 1);  // 1111 ^ 0011, 0000 ^ 0001
}

TEST(HammingCosts, OfOppositeDescriptorsAreAllTheirBits) {
  std::vector<std::uint8_t> rising(40), falling(40);
  for (std::size_t x = 0; x < rising.size(); ++x) {
    rising[x] = static_cast<std::uint8_t>(x);
    falling[x] = static_cast<std::uint8_t>(40 - x);
  }
  // Column 20: everything to one side is darker, and what lies straight above never is.
  std::array<std::span<const std::uint8_t>, 7> up, down;
  up.fill(rising);
  down.fill(falling);
  std::vector<std::uint8_t> a(planes_of(kCensus9x7.bits()) * 40), b(a);
  best::census_9x7(up, a);
  best::census_9x7(down, b);
  std::vector<std::uint8_t> left, right;
  for (std::size_t p = 0; p < planes_of(kCensus9x7.bits()); ++p) {
    left.push_back(a[p * 40 + 20]);
    right.insert(right.end(), 16, b[p * 40 + 20]);
  }
  std::vector<std::uint8_t> costs(16);
  best::hamming_costs(left, right, kCensus9x7.bits(), 16, costs);
  EXPECT_TRUE(std::ranges::all_of(costs, [](int cost) { return cost == 62 - 6; }));
}

TEST(HammingCosts, EqualsReferenceForEveryShape) {
  constexpr int kMost = (1 << kPlaneBits) - 1;
  for (const int bits : {kCensus5x5.bits(), kCensus9x7.bits()}) {
    for (const int lanes : {16, 32, 48, 64, 80, 128, 256}) {
      test::check_kernel(
          std::array<std::size_t, 6>{1, 2, 15, 16, 17, 33}, [&](test::KernelCase& c) {
            const std::size_t n = c.length(), count = static_cast<std::size_t>(lanes);
            const auto left = c.array<std::uint8_t>(planes_of(bits) * n, 0, kMost);
            const auto right = c.array<std::uint8_t>(planes_of(bits) * (n + count - 1), 0, kMost);
            const auto costs = c.array<std::uint8_t>(n * count);
            c.run([&] { best::hamming_costs(left, right, bits, lanes, costs); });
          });
    }
  }
}

}  // namespace
}  // namespace stof::dsp
