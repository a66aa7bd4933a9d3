#include "dsp/stereo/search/winner.h"

#include <algorithm>
#include <array>
#include <vector>

#include <gtest/gtest.h>

#include "tests/support/guarded_memory.h"
#include "tests/support/kernel_check.h"
#include "tests/support/random.h"

namespace stof::dsp {
namespace {

constexpr std::array<std::size_t, 5> kLengths{1, 2, 9, 31, 100};

template <typename Sum>
class Winner : public testing::Test {
 protected:
  // Costs with many ties and some missing candidates.
  static std::span<const Sum> costs(test::KernelCase& c, int lanes, int spread) {
    const int most = kNoCost<Sum> == 255 ? std::min(spread, 254) : spread;
    const auto out = c.array<Sum>(c.length() * static_cast<std::size_t>(lanes), 0, most);
    for (Sum& cost : out) {
      cost = c.random().between(0, 9) == 0 ? kNoCost<Sum> : cost;
    }
    return out;
  }
};
using Sums = testing::Types<std::uint8_t, std::uint16_t, std::uint32_t>;
TYPED_TEST_SUITE(Winner, Sums);

TYPED_TEST(Winner, LowestCostWinsAndTiesGoToTheSmallestCandidate) {
  std::vector<TypeParam> costs(32, 9);
  costs[5] = 3;
  costs[11] = 3;
  costs[16 + 7] = 10;
  std::vector<std::int16_t> winners(2);
  best::winners(std::span<const TypeParam>(costs), 16, winners);
  EXPECT_EQ(winners[0], 5);
  EXPECT_EQ(winners[1], 0);  // all but one are equal
}

TYPED_TEST(Winner, PixelWithoutCandidatesHasNone) {
  const std::vector<TypeParam> costs(16, kNoCost<TypeParam>);
  std::vector<std::int16_t> winners(1, 7);
  best::winners(std::span<const TypeParam>(costs), 16, winners);
  EXPECT_EQ(winners[0], kNoWinner);
}

TYPED_TEST(Winner, NothingWinsWhereAllCandidatesCostTheSame) {
  for (const TypeParam cost : {TypeParam{0}, TypeParam{77}, TypeParam(kNoCost<TypeParam> - 1)}) {
    for (const std::size_t offered : {std::size_t{1}, std::size_t{5}, std::size_t{16}}) {
      std::vector<TypeParam> costs(16, kNoCost<TypeParam>);
      std::fill_n(costs.begin(), offered, cost);
      std::vector<std::int16_t> winners(1);
      best::winners(std::span<const TypeParam>(costs), 16, winners);
      EXPECT_EQ(winners[0], kNoWinner);
    }
  }
}

TYPED_TEST(Winner, EqualsReferenceForEveryLaneCountAndLength) {
  for (int lanes = 16; lanes <= 256; lanes += 16) {
    for (const int spread : {0, 1, 3, 60000}) {
      test::check_kernel(kLengths, [&](test::KernelCase& c) {
        const auto costs = this->costs(c, lanes, spread);
        const auto winners = c.array<std::int16_t>(c.length());
        c.run([&] { best::winners(costs, lanes, winners); });
      });
    }
  }
}

TYPED_TEST(Winner, RightPixelTakesTheBestOfItsDiagonal) {
  // Two columns: j = 1 - x + i. Right pixel j = 3 meets column 0 as candidate 2, column 1 as 3.
  std::vector<TypeParam> costs(32, 50);
  costs[2] = 4;        // column 0, candidate 2
  costs[16 + 3] = 4;   // column 1, candidate 3: a tie, the smaller candidate stays
  costs[16 + 15] = 1;  // column 1, candidate 15: j = 15
  std::vector<TypeParam> lowest(17);
  std::vector<std::int16_t> winners(17);
  best::right_winners(std::span<const TypeParam>(costs), 16, std::span<TypeParam>(lowest), winners);
  EXPECT_EQ(winners[3], 2);
  EXPECT_EQ(winners[15], 15);
  EXPECT_EQ(winners[0], 0);
}

TYPED_TEST(Winner, EqualsReferenceForRightPixels) {
  for (int lanes = 16; lanes <= 256; lanes += 48) {
    for (const int spread : {1, 3, 60000}) {
      test::check_kernel(kLengths, [&](test::KernelCase& c) {
        const auto costs = this->costs(c, lanes, spread);
        const std::size_t right = c.length() + static_cast<std::size_t>(lanes) - 1;
        const auto lowest = c.array<TypeParam>(right);
        const auto winners = c.array<std::int16_t>(right);
        c.run([&] { best::right_winners(costs, lanes, lowest, winners); });
      });
    }
  }
}

}  // namespace
}  // namespace stof::dsp
