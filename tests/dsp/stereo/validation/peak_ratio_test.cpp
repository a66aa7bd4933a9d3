#include "dsp/stereo/validation/peak_ratio.h"

#include <algorithm>
#include <array>
#include <vector>

#include <gtest/gtest.h>

#include "dsp/stereo/cost/sad.h"
#include "dsp/stereo/search/block_winners.h"
#include "dsp/stereo/search/winner.h"
#include "tests/support/kernel_check.h"

namespace stof::dsp {
namespace {

constexpr std::array<std::size_t, 9> kPixels{0, 1, 2, 7, 15, 16, 17, 33, 41};

template <typename Sum>
class PeakRatioOf : public testing::Test {
 protected:
  static int ratio(const std::vector<Sum>& costs, std::int16_t winner) {
    std::uint8_t out = 7;
    best::peak_ratio(std::span<const Sum>(costs), 16, false, {&winner, 1}, {&out, 1});
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

TYPED_TEST(PeakRatioOf, EqualsReferenceForEveryLength) {
  for (const int lanes : {16, 48, 64, 256}) {
    for (const std::uint32_t spread : {1U, 40U, 254U, 65534U}) {
      test::check_kernel(kPixels, [&](test::KernelCase& c) {
        const std::size_t n = c.length();
        const int largest =
            static_cast<int>(std::min<std::uint32_t>(spread, kNoCost<TypeParam> - 1U));
        const auto costs = c.array<TypeParam>(n * static_cast<std::size_t>(lanes), 0, largest);
        for (TypeParam& cost : costs) {
          cost = c.random().between(0, 3) == 0 ? kNoCost<TypeParam> : cost;
        }
        const auto winners = c.array<std::int16_t>(n, kNoWinner, lanes - 1);
        const auto ratio = c.array<std::uint8_t>(n);
        c.run([&] { best::peak_ratio(costs, lanes, false, winners, ratio); });
      });
    }
  }
}

std::vector<std::uint16_t> numbered(std::vector<std::uint16_t> costs, int lanes) {
  for (std::size_t k = 0; k < costs.size(); ++k) {
    costs[k] = numbered_cost(costs[k], static_cast<int>(k) % lanes);
  }
  return costs;
}

TEST(PeakRatio, NumberedCostsHaveTheRatiosOfTheCosts) {
  test::Random random(7);
  for (const int lanes : {16, 32, 64, 112, 256}) {
    for (const int most : {1, 40, kLargestBlockSum}) {
      constexpr std::size_t kColumns = 83;
      std::vector<std::uint16_t> costs(kColumns * static_cast<std::size_t>(lanes));
      for (std::uint16_t& cost : costs) {
        cost = random.between(0, 5) == 0 ? kNoCost<std::uint16_t>
                                         : static_cast<std::uint16_t>(random.between(0, most));
      }
      std::vector<std::int16_t> winners(kColumns);
      ref::winners(std::span<const std::uint16_t>(costs), lanes, winners);
      winners[5] = kNoWinner;
      std::vector<std::uint8_t> expected(kColumns);
      std::vector<std::uint8_t> ratio(kColumns);
      ref::peak_ratio(std::span<const std::uint16_t>(costs), lanes, false, winners, expected);
      const std::vector<std::uint16_t> sums = numbered(costs, lanes);
      best::peak_ratio(std::span<const std::uint16_t>(sums), lanes, true, winners, ratio);
      EXPECT_EQ(ratio, expected) << lanes << " lanes, " << most;
    }
  }
}

// Every number of a group beside the costs 9 and 10: the numbers do not count.
TEST(PeakRatio, ANumberedRivalAsGoodIsATie) {
  for (int rival = 2; rival < 64; ++rival) {
    std::vector<std::uint16_t> costs(64, 10);
    costs[0] = 9;
    costs[static_cast<std::size_t>(rival)] = 9;
    const std::int16_t winner = 0;
    std::uint8_t out = 7;
    best::peak_ratio(std::span<const std::uint16_t>(numbered(costs, 64)), 64, true, {&winner, 1},
                     {&out, 1});
    EXPECT_EQ(out, kRatioOfTie) << rival;
  }
}

TEST(PeakRatio, OfNumberedCostsEqualsReferenceForEveryLength) {
  for (const int lanes : {16, 48, 64, 96, 256}) {
    for (const int most : {0, 1, 40, kLargestBlockSum}) {
      test::check_kernel(kPixels, [&](test::KernelCase& c) {
        const std::size_t n = c.length();
        const auto costs = c.array<std::uint16_t>(n * static_cast<std::size_t>(lanes), 0, most);
        for (std::size_t k = 0; k < costs.size(); ++k) {
          const bool none = c.random().between(0, 3) == 0;
          costs[k] =
              numbered_cost(none ? kNoCost<std::uint16_t> : costs[k], static_cast<int>(k) % lanes);
        }
        const auto winners = c.array<std::int16_t>(n, kNoWinner, lanes - 1);
        const auto ratio = c.array<std::uint8_t>(n);
        c.run([&] { best::peak_ratio(costs, lanes, true, winners, ratio); });
      });
    }
  }
}

}  // namespace
}  // namespace stof::dsp
