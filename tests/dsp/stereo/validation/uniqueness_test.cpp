#include "dsp/stereo/validation/uniqueness.h"

#include <array>
#include <vector>

#include <gtest/gtest.h>

#include "tests/support/kernel_check.h"

namespace stof::dsp {
namespace {

constexpr std::array<std::size_t, 9> kPixels{0, 1, 2, 7, 8, 9, 17, 33, 41};

template <typename Sum>
class Uniqueness : public testing::Test {
 protected:
  static bool stays(const std::vector<Sum>& costs, std::int16_t winner, int percent) {
    std::vector<std::int16_t> winners{winner};
    best::uniqueness_check(std::span<const Sum>(costs), 16, percent, winners);
    return winners[0] == winner;
  }
};
using Sums = testing::Types<std::uint8_t, std::uint16_t, std::uint32_t>;
TYPED_TEST_SUITE(Uniqueness, Sums);

TYPED_TEST(Uniqueness, ARivalMustCostMoreByThePercentage) {
  std::vector<TypeParam> costs(16, 250);
  costs[6] = 100;
  costs[11] = 115;
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

TYPED_TEST(Uniqueness, EqualsReferenceForEveryLength) {
  for (const int lanes : {16, 48, 256}) {
    for (const int spread : {1, 3, 254, 2000, 65534}) {
      if (sizeof(TypeParam) == 1 && spread > 254) {
        continue;
      }
      test::check_kernel(kPixels, [&](test::KernelCase& c) {
        const std::size_t n = c.length();
        const auto costs = c.array<TypeParam>(n * static_cast<std::size_t>(lanes), 0, spread);
        for (TypeParam& cost : costs) {
          cost = c.random().between(0, 3) == 0 ? kNoCost<TypeParam> : cost;
        }
        const auto winners = c.array<std::int16_t>(n);
        ref::winners<TypeParam>(costs, lanes, winners);
        for (std::size_t k = 2; k < n; k += 5) {
          winners[k] = static_cast<std::int16_t>(c.draw(kNoWinner, lanes - 1));
        }
        c.run([&] { best::uniqueness_check(costs, lanes, 4, winners); });
      });
    }
  }
}

}  // namespace
}  // namespace stof::dsp
