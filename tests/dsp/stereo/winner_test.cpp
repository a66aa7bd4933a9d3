#include "dsp/stereo/search/winner.h"

#include <algorithm>
#include <vector>

#include <gtest/gtest.h>

#include "tests/support/guarded.h"
#include "tests/support/random.h"
#include "tests/support/vectors.h"

namespace stof::dsp {
namespace {

template <typename Sum>
class Winner : public testing::Test {
 protected:
  // Costs with many ties and some missing candidates.
  static test::GuardedBuffer<Sum> costs(std::size_t n, int lanes, std::uint64_t seed, int spread) {
    test::GuardedBuffer<Sum> out(n * static_cast<std::size_t>(lanes));
    test::Random random(seed);
    random.fill(out.span(), 0, std::min(spread, int{kNoCost<Sum> == 255 ? 254 : spread}));
    for (Sum& cost : out.span()) {
      if (random.between(0, 9) == 0) {
        cost = kNoCost<Sum>;
      }
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
  for (auto* const find : {static_cast<Winners<TypeParam>*>(ref::winners),
                           static_cast<Winners<TypeParam>*>(neon::winners)}) {
    find(std::span<const TypeParam>(costs), 16, winners);
    EXPECT_EQ(winners[0], 5);
    EXPECT_EQ(winners[1], 0);  // all but one are equal
  }
}

TYPED_TEST(Winner, PixelWithoutCandidatesHasNone) {
  const std::vector<TypeParam> costs(16, kNoCost<TypeParam>);
  std::vector<std::int16_t> winners(1, 7);
  neon::winners(std::span<const TypeParam>(costs), 16, winners);
  EXPECT_EQ(winners[0], kNoWinner);
}

TYPED_TEST(Winner, NothingWinsWhereAllCandidatesCostTheSame) {
  for (const TypeParam cost : {TypeParam{0}, TypeParam{77}, TypeParam(kNoCost<TypeParam> - 1)}) {
    for (const std::size_t offered : {std::size_t{1}, std::size_t{5}, std::size_t{16}}) {
      std::vector<TypeParam> costs(16, kNoCost<TypeParam>);
      std::fill_n(costs.begin(), offered, cost);
      std::vector<std::int16_t> winners(1);
      ref::winners(std::span<const TypeParam>(costs), 16, winners);
      EXPECT_EQ(winners[0], kNoWinner);
      neon::winners(std::span<const TypeParam>(costs), 16, winners);
      EXPECT_EQ(winners[0], kNoWinner);
    }
  }
}

TYPED_TEST(Winner, VectorsEqualReferenceForEveryLaneCountAndLength) {
  for (const Vectors vectors : test::all_vectors()) {
    const test::UseVectors use(vectors);
    for (int lanes = 16; lanes <= 256; lanes += 16) {
      for (const std::size_t n : {1U, 2U, 9U, 31U}) {
        for (const int spread : {0, 1, 3, 60000}) {
          const auto costs = this->costs(n, lanes, n + static_cast<std::size_t>(lanes), spread);
          test::GuardedBuffer<std::int16_t> reference(n), neon(n);
          ref::winners(costs.span(), lanes, reference.span());
          best::winners(costs.span(), lanes, neon.span());
          ASSERT_TRUE(std::ranges::equal(reference.span(), neon.span())) << lanes << " x " << n;
        }
      }
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
  ref::right_winners(std::span<const TypeParam>(costs), 16, std::span<TypeParam>(lowest), winners);
  EXPECT_EQ(winners[3], 2);
  EXPECT_EQ(winners[15], 15);
  EXPECT_EQ(winners[0], 0);
}

TYPED_TEST(Winner, VectorsEqualReferenceForRightPixels) {
  for (const Vectors vectors : test::all_vectors()) {
    const test::UseVectors use(vectors);
    for (int lanes = 16; lanes <= 256; lanes += 48) {
      for (const std::size_t n : {1U, 2U, 9U, 31U, 100U}) {
        for (const int spread : {1, 3, 60000}) {
          const auto costs = this->costs(n, lanes, n, spread);
          const std::size_t right = n + static_cast<std::size_t>(lanes) - 1;
          test::GuardedBuffer<TypeParam> lowest_ref(right), lowest_neon(right);
          test::GuardedBuffer<std::int16_t> reference(right), neon(right);
          ref::right_winners(costs.span(), lanes, lowest_ref.span(), reference.span());
          best::right_winners(costs.span(), lanes, lowest_neon.span(), neon.span());
          ASSERT_TRUE(std::ranges::equal(reference.span(), neon.span())) << lanes << " x " << n;
          ASSERT_TRUE(std::ranges::equal(lowest_ref.span(), lowest_neon.span()));
        }
      }
    }
  }
}

}  // namespace
}  // namespace stof::dsp
