#include "lab/block/interest.h"

#include <vector>

#include <gtest/gtest.h>

#include "dsp/stereo/search/winner.h"

namespace stof::lab {
namespace {

using Mask = std::vector<std::uint8_t>;
constexpr int kCap = 15;

// Derivatives as clipped_sobel() stores them.
std::vector<std::uint8_t> derivative(const std::vector<int>& values) {
  std::vector<std::uint8_t> out;
  for (const int value : values) {
    out.push_back(static_cast<std::uint8_t>(value + kCap));
  }
  return out;
}

Mask maxima(const std::vector<int>& values, int threshold) {
  Mask mask(values.size(), 9);
  interest_maxima(derivative(values), kCap, threshold, mask);
  return mask;
}

TEST(Interest, MaximaAreFoundOfEitherSignAboveTheThreshold) {
  EXPECT_EQ(maxima({0, 3, 9, 3, 0, -8, -2, 4, 0}, 5), (Mask{0, 0, 1, 0, 0, 1, 0, 0, 0}));
  EXPECT_EQ(maxima({7, 3, 0, 6}, 5), (Mask{1, 0, 0, 1}));
}

TEST(Interest, APlateauCountsOnceAndAStepOnTheWayUpNotAtAll) {
  EXPECT_EQ(maxima({0, 15, 15, 15, 0, 0}, 5), (Mask{0, 0, 1, 0, 0, 0}));
  EXPECT_EQ(maxima({0, 15, 15, 0}, 5), (Mask{0, 1, 0, 0}));
  EXPECT_EQ(maxima({0, 6, 6, 9, 0}, 5), (Mask{0, 0, 0, 1, 0}));
  EXPECT_EQ(maxima({}, 5), Mask{});
}

TEST(Interest, ThresholdsOfBothPictures) {
  const auto row = derivative({0, 6, -9, 15, 5});
  Mask left(5), right(5);
  interest_above(row, kCap, 9, left);
  interest_above(row, kCap, 6, right);
  EXPECT_EQ(left, (Mask{0, 0, 1, 1, 0}));
  EXPECT_EQ(right, (Mask{0, 1, 1, 1, 0}));
}

TEST(Interest, OnlyPairsOfInterestingPositionsAreMatched) {
  // Columns 0 .. 4; candidate i of column x meets right column x + 1 - i.
  const Mask left{0, 0, 0, 1, 1};
  const Mask right{1, 0, 1, 0, 0};
  std::vector<std::uint16_t> costs(5 * 16, 50);
  costs[3 * 16 + 1] = 7;  // meets right column 3: cheap but not interesting
  costs[3 * 16 + 4] = 9;  // meets right column 0
  keep_interesting(left, right, -1, 16, std::span<std::uint16_t>(costs));
  for (std::size_t i = 0; i < 16; ++i) {
    EXPECT_EQ(costs[i], kNoCost<std::uint16_t>);
    EXPECT_EQ(costs[3 * 16 + i] != kNoCost<std::uint16_t>, i == 2 || i == 4) << i;
    EXPECT_EQ(costs[4 * 16 + i] != kNoCost<std::uint16_t>, i == 3 || i == 5) << i;
  }
  std::vector<std::int16_t> winners(5);
  interesting_winners(std::span<const std::uint16_t>(costs), 16, winners);
  EXPECT_EQ(winners, (std::vector<std::int16_t>{kNoWinner, kNoWinner, kNoWinner, 4, 3}));
}

TEST(Interest, ASingleInterestingCandidateWins) {
  std::vector<std::uint32_t> costs(16, 3);
  keep_interesting(Mask{1}, Mask{1}, 0, 16, std::span<std::uint32_t>(costs));
  std::vector<std::int16_t> winners(1);
  interesting_winners(std::span<const std::uint32_t>(costs), 16, winners);
  EXPECT_EQ(winners[0], 0);
}

}  // namespace
}  // namespace stof::lab
