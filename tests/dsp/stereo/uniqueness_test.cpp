#include "dsp/stereo/check/uniqueness.h"

#include <algorithm>
#include <vector>

#include <gtest/gtest.h>

#include "tests/support/guarded.h"
#include "tests/support/random.h"

namespace stof::dsp {
namespace {

template <typename Sum>
class Uniqueness : public testing::Test {
 protected:
  static bool stays(const std::vector<Sum>& costs, std::int16_t winner, int percent) {
    std::vector<std::int16_t> winners{winner};
    ref::uniqueness_check(std::span<const Sum>(costs), 16, percent, winners);
    return winners[0] == winner;
  }
};
using Sums = testing::Types<std::uint16_t, std::uint32_t>;
TYPED_TEST_SUITE(Uniqueness, Sums);

TYPED_TEST(Uniqueness, ARivalMustCostMoreByThePercentage) {
  std::vector<TypeParam> costs(16, 1000);
  costs[6] = 200;
  costs[11] = 230;
  EXPECT_TRUE(this->stays(costs, 6, 15));
  EXPECT_FALSE(this->stays(costs, 6, 16));
}

TYPED_TEST(Uniqueness, NeighboursAndMissingCandidatesAreNoRivals) {
  std::vector<TypeParam> costs(16, kNoCost<TypeParam>);
  costs[6] = 200;
  costs[5] = 200;
  costs[7] = 201;
  EXPECT_TRUE(this->stays(costs, 6, 99));
  costs[8] = 201;
  EXPECT_FALSE(this->stays(costs, 6, 1));
}

TYPED_TEST(Uniqueness, TwoPerfectMatchesAreNone) {
  std::vector<TypeParam> costs(16, 9);
  costs[0] = 0;
  costs[15] = 0;
  EXPECT_FALSE(this->stays(costs, 0, 10));
  costs[15] = 1;
  EXPECT_TRUE(this->stays(costs, 0, 10));
}

TYPED_TEST(Uniqueness, NeonEqualsReferenceForEveryLength) {
  for (const int lanes : {16, 48, 256}) {
    for (std::size_t n = 0; n <= 41; ++n) {
      for (const int spread : {1, 3, 2000, 65534}) {
        test::GuardedBuffer<TypeParam> costs(n * static_cast<std::size_t>(lanes));
        test::GuardedBuffer<std::int16_t> reference(n), neon(n);
        test::Random random(n + static_cast<std::size_t>(spread + lanes));
        random.fill(costs.span(), 0, spread);
        for (TypeParam& cost : costs.span()) {
          cost = random.between(0, 3) == 0 ? kNoCost<TypeParam> : cost;
        }
        ref::winners(std::span<const TypeParam>(costs.span()), lanes, reference.span());
        for (std::size_t k = 2; k < n; k += 5) {
          reference[k] = static_cast<std::int16_t>(random.between(kNoWinner, lanes - 1));
        }
        std::ranges::copy(reference.span(), neon.span().begin());
        ref::uniqueness_check(std::span<const TypeParam>(costs.span()), lanes, 4, reference.span());
        neon::uniqueness_check(std::span<const TypeParam>(costs.span()), lanes, 4, neon.span());
        ASSERT_TRUE(std::ranges::equal(reference.span(), neon.span())) << n << " x " << lanes;
      }
    }
  }
}

}  // namespace
}  // namespace stof::dsp
