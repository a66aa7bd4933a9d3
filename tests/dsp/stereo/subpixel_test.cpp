#include "dsp/stereo/refine/subpixel.h"

#include <algorithm>
#include <array>
#include <vector>

#include <gtest/gtest.h>

#include "tests/support/guarded.h"
#include "tests/support/random.h"

namespace stof::dsp {
namespace {

template <typename Sum>
class Subpixel : public testing::Test {};
using Sums = testing::Types<std::uint16_t, std::uint32_t>;
TYPED_TEST_SUITE(Subpixel, Sums);

template <typename Sum>
std::int16_t refine_one(Sum before, Sum best, Sum after,
                        RefineWinners<Sum>* refine = ref::refine_winners) {
  std::vector<Sum> costs(16, 60000);
  costs[4] = before;
  costs[5] = best;
  costs[6] = after;
  const std::vector<std::int16_t> winners{5};
  std::vector<Disparity> out(1);
  refine(std::span<const Sum>(costs), 16, -2, winners, out);
  return out[0].raw;
}

TYPED_TEST(Subpixel, FitsTwoLinesOfEqualSlope) {
  using Sum = TypeParam;
  EXPECT_EQ(refine_one<Sum>(200, 100, 200), 3 * 16);      // symmetric
  EXPECT_EQ(refine_one<Sum>(300, 100, 100), 3 * 16 + 8);  // half way to the next candidate
  EXPECT_EQ(refine_one<Sum>(100, 100, 300), 3 * 16 - 8);
  EXPECT_EQ(refine_one<Sum>(300, 100, 200), 3 * 16 + 4);       // a quarter
  EXPECT_EQ(refine_one<Sum>(100, 100, 100), 3 * 16);           // flat: nothing to fit
  EXPECT_EQ(refine_one<Sum>(kNoCost<Sum>, 100, 200), 3 * 16);  // no neighbour, no fit
}

TYPED_TEST(Subpixel, MovesTowardTheSmallerNeighbour) {
  EXPECT_GT(refine_one<TypeParam>(500, 100, 400), 3 * 16);
  EXPECT_LT(refine_one<TypeParam>(400, 100, 500), 3 * 16);
}

TYPED_TEST(Subpixel, FitsAParabola) {
  using Sum = TypeParam;
  const auto fit = [](int before, int best, int after) {
    return refine_one<Sum>(static_cast<Sum>(before), static_cast<Sum>(best),
                           static_cast<Sum>(after), ref::refine_winners_parabola);
  };
  // 160 (x - s)^2 at x = -1, 0, 1 for s = 1/4: 250, 10, 90.
  EXPECT_EQ(fit(250, 10, 90), 3 * 16 + 4);
  EXPECT_EQ(fit(90, 10, 250), 3 * 16 - 4);
  EXPECT_EQ(fit(300, 100, 100), 3 * 16 + 8);
  EXPECT_EQ(fit(200, 100, 200), 3 * 16);
  EXPECT_EQ(fit(100, 100, 100), 3 * 16);
  EXPECT_EQ(refine_one<Sum>(kNoCost<Sum>, 100, 200, ref::refine_winners_parabola), 3 * 16);
}

TYPED_TEST(Subpixel, AWinnerThatIsNoMinimumStaysWhole) {
  for (auto* const refine :
       {static_cast<RefineWinners<TypeParam>*>(ref::refine_winners),
        static_cast<RefineWinners<TypeParam>*>(ref::refine_winners_parabola)}) {
    EXPECT_EQ(refine_one<TypeParam>(50, 100, 300, refine), 3 * 16);
    EXPECT_EQ(refine_one<TypeParam>(300, 100, 99, refine), 3 * 16);
  }
}

TYPED_TEST(Subpixel, NeonEqualsReferenceOnEveryRatioAndBorder) {
  for (const int lanes : {16, 64}) {
    for (std::size_t n = 0; n <= 40; ++n) {
      for (const int spread : {2, 40, 65000}) {
        test::GuardedBuffer<TypeParam> costs(n * static_cast<std::size_t>(lanes));
        test::GuardedBuffer<std::int16_t> winners(n);
        test::GuardedBuffer<Disparity> reference(n), neon(n);
        test::Random random(n + static_cast<std::size_t>(spread));
        random.fill(costs.span(), 0, spread);
        for (TypeParam& cost : costs.span()) {
          cost = random.between(0, 15) == 0 ? kNoCost<TypeParam> : cost;
        }
        neon::winners(std::span<const TypeParam>(costs.span()), lanes, winners.span());
        if (n > 2) {
          winners[1] = kNoWinner;
          winners[2] = 7;  // hardly ever the minimum
        }
        ref::refine_winners_parabola(std::span<const TypeParam>(costs.span()), lanes, -7,
                                     winners.span(), reference.span());
        neon::refine_winners_parabola(std::span<const TypeParam>(costs.span()), lanes, -7,
                                      winners.span(), neon.span());
        ASSERT_TRUE(std::ranges::equal(reference.span(), neon.span())) << n << " x " << lanes;
        ref::refine_winners(std::span<const TypeParam>(costs.span()), lanes, -7, winners.span(),
                            reference.span());
        neon::refine_winners(std::span<const TypeParam>(costs.span()), lanes, -7, winners.span(),
                             neon.span());
        ASSERT_TRUE(std::ranges::equal(reference.span(), neon.span())) << n << " x " << lanes;
        ref::whole_winners(-7, winners.span(), reference.span());
        neon::whole_winners(-7, winners.span(), neon.span());
        ASSERT_TRUE(std::ranges::equal(reference.span(), neon.span())) << n;
      }
    }
  }
}

}  // namespace
}  // namespace stof::dsp
