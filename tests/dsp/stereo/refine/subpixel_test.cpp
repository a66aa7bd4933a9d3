#include "dsp/stereo/refine/subpixel.h"

#include <vector>

#include <gtest/gtest.h>

#include "tests/support/kernel_check.h"

namespace stof::dsp {
namespace {

template <typename Sum>
class Subpixel : public testing::Test {};
using Sums = testing::Types<std::uint16_t, std::uint32_t>;
TYPED_TEST_SUITE(Subpixel, Sums);

template <typename Sum>
std::int16_t refine_one(Sum before, Sum lowest, Sum after, CostFit fit = CostFit::kEquiangular) {
  std::vector<Sum> costs(16, 60000);
  costs[4] = before;
  costs[5] = lowest;
  costs[6] = after;
  const std::vector<std::int16_t> winners{5};
  std::vector<Disparity> out(1);
  best::refine_winners(std::span<const Sum>(costs), 16, fit, -2, winners, out);
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
                           static_cast<Sum>(after), CostFit::kParabola);
  };
  // 160 (x - s)^2 at x = -1, 0, 1 for s = 1/4: 250, 10, 90.
  EXPECT_EQ(fit(250, 10, 90), 3 * 16 + 4);
  EXPECT_EQ(fit(90, 10, 250), 3 * 16 - 4);
  EXPECT_EQ(fit(300, 100, 100), 3 * 16 + 8);
  EXPECT_EQ(fit(200, 100, 200), 3 * 16);
  EXPECT_EQ(fit(100, 100, 100), 3 * 16);
  EXPECT_EQ(refine_one<Sum>(kNoCost<Sum>, 100, 200, CostFit::kParabola), 3 * 16);
}

TYPED_TEST(Subpixel, AWinnerThatIsNoMinimumStaysWhole) {
  for (const CostFit fit : {CostFit::kEquiangular, CostFit::kParabola}) {
    EXPECT_EQ(refine_one<TypeParam>(50, 100, 300, fit), 3 * 16);
    EXPECT_EQ(refine_one<TypeParam>(300, 100, 99, fit), 3 * 16);
  }
}

TYPED_TEST(Subpixel, EqualsReferenceOnEveryRatioAndBorder) {
  for (const int lanes : {16, 64}) {
    for (const int spread : {2, 40, 65000}) {
      test::check_kernel([&](test::KernelCase& c) {
        const std::size_t n = c.length();
        const auto costs = c.array<TypeParam>(n * static_cast<std::size_t>(lanes), 0, spread);
        for (TypeParam& cost : costs) {
          cost = c.random().between(0, 15) == 0 ? kNoCost<TypeParam> : cost;
        }
        const auto winners = c.array<std::int16_t>(n);
        ref::winners<TypeParam>(costs, lanes, winners);
        if (n > 2) {
          winners[1] = kNoWinner;
          winners[2] = 7;  // hardly ever the minimum
        }
        const auto parabola = c.array<Disparity>(n), lines = c.array<Disparity>(n);
        const auto whole = c.array<Disparity>(n);
        const auto fit = [&](CostFit how, std::span<Disparity> out) {
          best::refine_winners(std::span<const TypeParam>(costs), lanes, how, -7, winners, out);
        };
        c.run([&] { fit(CostFit::kParabola, parabola); });
        c.run([&] { fit(CostFit::kEquiangular, lines); });
        c.run([&] { fit(CostFit::kNone, whole); });
      });
    }
  }
}

}  // namespace
}  // namespace stof::dsp
