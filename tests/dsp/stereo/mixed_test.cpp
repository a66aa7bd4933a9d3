#include "dsp/stereo/cost/mixed.h"

#include <algorithm>
#include <vector>

#include <gtest/gtest.h>

#include "dsp/stereo/cost/census.h"
#include "tests/support/guarded.h"
#include "tests/support/random.h"
#include "tests/support/vectors.h"

namespace stof::dsp {
namespace {

constexpr int kLargestByte = (1 << kPlaneBits) - 1;

constexpr std::size_t kPlanes = planes_of(kCensus5x5Bits);

struct Side {
  test::GuardedBuffer<std::uint8_t> planes, grey;
  Side(std::size_t n, std::uint64_t seed) : planes(kPlanes * n), grey(n) {
    test::Random random(seed);
    random.fill(planes.span(), 0, kLargestByte);
    random.fill(grey.span());
  }
  MixedRow row() const { return {planes.span(), grey.span()}; }
};

TEST(MixedCosts, AddHalfTheClippedGreyDifferenceToTheHammingDistance) {
  const std::vector<std::uint8_t> no_bits(kPlanes, 0);
  std::vector<std::uint8_t> planes(kPlanes * 16, 0);
  planes[3] = 0b0111;  // candidate 3: three bits
  std::vector<std::uint8_t> grey(16, 100);
  grey[1] = 95;   // 5 levels: 5 / 2 = 2
  grey[2] = 255;  // clipped at 6: 3
  grey[4] = 102;  // 2 / 2 = 1
  const std::vector<std::uint8_t> own_grey{100};
  std::vector<std::uint8_t> costs(16, 99);
  ref::mixed_costs({no_bits, own_grey}, {planes, grey}, 16, costs);
  EXPECT_EQ(costs, (std::vector<std::uint8_t>{0, 2, 3, 3, 1, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0}));
}

TEST(MixedCosts, StayWithinTheBoundThatSumsAreSizedBy) {
  const std::vector<std::uint8_t> zeros(kPlanes, 0), black{0};
  const std::vector<std::uint8_t> white(16, 255);
  std::vector<std::uint8_t> ones(kPlanes * 16, kLargestByte);
  std::vector<std::uint8_t> costs(16);
  ref::mixed_costs({zeros, black}, {ones, white}, 16, costs);
  EXPECT_EQ(costs, std::vector<std::uint8_t>(16, kLargestMixedCost));
}

TEST(MixedCosts, VectorsEqualReferenceForEveryShape) {
  for (const Vectors vectors : test::all_vectors()) {
    const test::UseVectors use(vectors);
    for (const int lanes : {16, 48, 64, 80, 128, 256}) {
      for (std::size_t n = 1; n <= 40; ++n) {
        const std::size_t count = static_cast<std::size_t>(lanes);
        const Side left(n, n);
        const Side right(n + count - 1, n + 99);
        test::GuardedBuffer<std::uint8_t> reference(n * count, 1), neon(n * count, 2);
        ref::mixed_costs(left.row(), right.row(), lanes, reference.span());
        best::mixed_costs(left.row(), right.row(), lanes, neon.span());
        ASSERT_TRUE(std::ranges::equal(reference.span(), neon.span()))
            << lanes << " lanes, " << n << " columns";
      }
    }
  }
}

}  // namespace
}  // namespace stof::dsp
