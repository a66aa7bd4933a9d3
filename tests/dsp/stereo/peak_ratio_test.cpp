#include "dsp/stereo/check/peak_ratio.h"

#include <algorithm>
#include <vector>

#include <gtest/gtest.h>

#include "dsp/stereo/cost/sad.h"
#include "dsp/stereo/search/winner.h"
#include "tests/support/guarded.h"
#include "tests/support/random.h"
#include "tests/support/vectors.h"

namespace stof::dsp {
namespace {

template <typename Sum>
class PeakRatioOf : public testing::Test {
 protected:
  static int ratio(const std::vector<Sum>& costs, std::int16_t winner) {
    std::uint8_t out = 7;
    ref::peak_ratio(std::span<const Sum>(costs), 16, {&winner, 1}, {&out, 1});
    return out;
  }
};
using Sums = testing::Types<std::uint8_t, std::uint16_t, std::uint32_t>;
TYPED_TEST_SUITE(PeakRatioOf, Sums);

TYPED_TEST(PeakRatioOf, IsTheShareOfTheBestRival) {
  std::vector<TypeParam> costs(16, 200);
  costs[6] = 50;
  EXPECT_EQ(this->ratio(costs, 6), 63);  // 255 / 4
  costs[11] = 100;
  EXPECT_EQ(this->ratio(costs, 6), 127);
  costs[6] = 0;
  EXPECT_EQ(this->ratio(costs, 6), 0);
}

TYPED_TEST(PeakRatioOf, NeighboursAreNoRivals) {
  std::vector<TypeParam> costs(16, 200);
  costs[5] = 50;
  costs[6] = 50;
  costs[7] = 51;
  EXPECT_EQ(this->ratio(costs, 6), 63);
  costs[8] = 51;
  EXPECT_EQ(this->ratio(costs, 6), 250);
  costs[0] = 40;
  EXPECT_EQ(this->ratio(costs, 0), 204);
  costs[15] = 20;
  EXPECT_EQ(this->ratio(costs, 15), 127);
}

TYPED_TEST(PeakRatioOf, ARivalAsGoodAndNothingToCompareAreTheSame) {
  std::vector<TypeParam> costs(16, 9);
  EXPECT_EQ(this->ratio(costs, 3), 255);
  std::ranges::fill(costs, TypeParam{0});
  EXPECT_EQ(this->ratio(costs, 3), 255);
  std::ranges::fill(costs, kNoCost<TypeParam>);
  EXPECT_EQ(this->ratio(costs, 3), 255);  // the winner has no cost
  costs[3] = 1;
  costs[4] = 2;
  EXPECT_EQ(this->ratio(costs, 3), 255);  // no rival
  costs[9] = 0;
  EXPECT_EQ(this->ratio(costs, 3), 255);  // the rival is better
  EXPECT_EQ(this->ratio(costs, kNoWinner), 255);
}

TYPED_TEST(PeakRatioOf, VectorsEqualReferenceForEveryLength) {
  for (const Vectors vectors : test::all_vectors()) {
    const test::UseVectors use(vectors);
    for (const int lanes : {16, 48, 256}) {
      for (std::size_t n = 0; n <= 41; ++n) {
        for (const int spread : {1, 40, 254, 65534}) {
          const int largest = static_cast<int>(
              std::min<std::uint32_t>(static_cast<std::uint32_t>(spread), kNoCost<TypeParam> - 1U));
          test::GuardedBuffer<TypeParam> costs(n * static_cast<std::size_t>(lanes));
          test::GuardedBuffer<std::int16_t> winners(n);
          test::GuardedBuffer<std::uint8_t> a(n), b(n);
          test::Random random(n + static_cast<std::size_t>(spread + lanes));
          random.fill(costs.span(), 0, largest);
          for (TypeParam& cost : costs.span()) {
            cost = random.between(0, 3) == 0 ? kNoCost<TypeParam> : cost;
          }
          random.fill(winners.span(), kNoWinner, lanes - 1);
          ref::peak_ratio(std::span<const TypeParam>(costs.span()), lanes, winners.span(),
                          a.span());
          best::peak_ratio(std::span<const TypeParam>(costs.span()), lanes, winners.span(),
                           b.span());
          ASSERT_TRUE(std::ranges::equal(a.span(), b.span())) << n << " x " << lanes;
        }
      }
    }
  }
}

}  // namespace
}  // namespace stof::dsp
