#include "dsp/stereo/search/numbered_right_winners.h"

#include <array>
#include <vector>

#include <gtest/gtest.h>

#include "dsp/stereo/search/block_winners.h"
#include "tests/support/kernel_check.h"

namespace stof::dsp {
namespace {

std::vector<std::uint16_t> numbered(std::vector<std::uint16_t> costs, int lanes) {
  for (std::size_t k = 0; k < costs.size(); ++k) {
    costs[k] = numbered_cost(costs[k], static_cast<int>(k) % lanes);
  }
  return costs;
}

TEST(NumberedRightWinners, RightPixelTakesTheBestOfItsDiagonal) {
  // Two columns: j = 1 - x + i. Right pixel j = 3 meets column 0 as candidate 2, column 1 as 3.
  std::vector<std::uint16_t> costs(32, 50);
  costs[2] = 4;        // column 0, candidate 2
  costs[16 + 3] = 4;   // column 1, candidate 3: a tie, the smaller candidate stays
  costs[16 + 15] = 1;  // column 1, candidate 15: j = 15
  costs[9] = costs[16 + 10] = kNoCost<std::uint16_t>;  // all of j = 10
  std::vector<std::int16_t> winners(17);
  best::numbered_right_winners(numbered(costs, 16), 16, winners);
  EXPECT_EQ(winners[3], 2);
  EXPECT_EQ(winners[15], 15);
  EXPECT_EQ(winners[0], 0);
  EXPECT_EQ(winners[10], kNoWinner);
}

TEST(NumberedRightWinners, AreThoseOfTheCostsThemselves) {
  constexpr int kLanes = 80;
  test::Random random(21);
  for (const int most : {1, 9, kLargestBlockSum}) {
    std::vector<std::uint16_t> costs(150 * kLanes);
    for (std::uint16_t& cost : costs) {
      cost = random.between(0, 9) == 0 ? kNoCost<std::uint16_t>
                                       : static_cast<std::uint16_t>(random.between(0, most));
    }
    std::vector<std::uint16_t> lowest(150 + kLanes - 1);
    std::vector<std::int16_t> expected(lowest.size());
    std::vector<std::int16_t> winners(lowest.size());
    ref::right_winners(std::span<const std::uint16_t>(costs), kLanes,
                       std::span<std::uint16_t>(lowest), expected);
    best::numbered_right_winners(numbered(costs, kLanes), kLanes, winners);
    EXPECT_EQ(winners, expected) << most;
  }
}

TEST(NumberedRightWinners, EqualsReference) {
  constexpr std::array<std::size_t, 8> kLengths{1, 2, 9, 31, 80, 100, 150, 300};
  for (int lanes = 16; lanes <= 256; lanes += 16) {
    for (const int most : {0, 1, 9, kLargestBlockSum}) {
      test::check_kernel(kLengths, [&](test::KernelCase& c) {
        const auto costs =
            c.array<std::uint16_t>(c.length() * static_cast<std::size_t>(lanes), 0, most);
        for (std::size_t k = 0; k < costs.size(); ++k) {
          const bool none = c.random().between(0, 9) == 0;
          costs[k] =
              numbered_cost(none ? kNoCost<std::uint16_t> : costs[k], static_cast<int>(k) % lanes);
        }
        const auto winners =
            c.array<std::int16_t>(c.length() + static_cast<std::size_t>(lanes) - 1);
        c.run([&] { best::numbered_right_winners(costs, lanes, winners); });
      });
    }
  }
}

}  // namespace
}  // namespace stof::dsp
