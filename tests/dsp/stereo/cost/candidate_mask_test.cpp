#include "dsp/stereo/cost/candidate_mask.h"

#include <algorithm>
#include <vector>

#include <gtest/gtest.h>

#include "dsp/stereo/search/winner.h"
#include "tests/support/kernel_check.h"

namespace stof::dsp {
namespace {

template <typename Sum>
class MaskCandidates : public testing::Test {};
using Sums = testing::Types<std::uint8_t, std::uint16_t, std::uint32_t>;
TYPED_TEST_SUITE(MaskCandidates, Sums);

// The candidates that keep their cost.
template <typename Sum>
std::vector<int> kept(Candidates may, int lanes = 16) {
  const std::vector<Sum> costs(static_cast<std::size_t>(lanes), 7);
  std::vector<Sum> out(costs.size(), 1);
  best::mask_candidates(std::span<const Sum>(costs), GuideRow(&may, 1), lanes, std::span(out));
  std::vector<int> left;
  for (int i = 0; i < lanes; ++i) {
    const Sum cost = out[static_cast<std::size_t>(i)];
    if (cost != kNoCost<Sum>) {
      EXPECT_EQ(cost, 7);
      left.push_back(i);
    }
  }
  return left;
}

TYPED_TEST(MaskCandidates, LeavesTheRangeAndOneMoreToEitherSide) {
  EXPECT_EQ(kept<TypeParam>({4, 6}), (std::vector{3, 4, 5, 6, 7}));
  EXPECT_EQ(kept<TypeParam>({9, 9}), (std::vector{8, 9, 10}));
  EXPECT_EQ(kept<TypeParam>({0, 1}), (std::vector{0, 1, 2}));
  EXPECT_EQ(kept<TypeParam>({14, 200}), (std::vector{13, 14, 15}));
  EXPECT_EQ(kept<TypeParam>({16, 255}), (std::vector{15}));
  EXPECT_EQ(kept<TypeParam>({17, 255}), (std::vector<int>{}));
  EXPECT_EQ(kept<TypeParam>({9, 3}), (std::vector<int>{}));
  EXPECT_EQ(kept<TypeParam>({255, 255}, 256), (std::vector{254, 255}));
  EXPECT_EQ(kept<TypeParam>({}).size(), 16U);
  EXPECT_EQ(kept<TypeParam>({}, 256).size(), 256U);
}

TYPED_TEST(MaskCandidates, EqualReferenceForEveryLength) {
  for (const int lanes : {16, 48, 64, 240, 256}) {
    test::check_kernel(std::array<std::size_t, 6>{0, 1, 2, 9, 16, 19}, [&](test::KernelCase& c) {
      const std::size_t count = c.length() * static_cast<std::size_t>(lanes);
      const auto costs = c.array<TypeParam>(count);
      const auto guide = c.array<Candidates>(c.length());
      for (Candidates& may : guide) {
        const int first = c.random().between(0, 3) == 0 ? 0 : c.draw(0, lanes - 1);
        const int last = c.random().between(0, 3) == 0 ? 255 : c.draw(0, lanes - 1);
        may = {static_cast<std::uint8_t>(first), static_cast<std::uint8_t>(last)};
      }
      const auto out = c.array<TypeParam>(count);
      c.run([&] { best::mask_candidates(std::span<const TypeParam>(costs), guide, lanes, out); });
      c.run([&] { best::mask_candidates(std::span<const TypeParam>(costs), guide, lanes, costs); });
      ASSERT_TRUE(std::ranges::equal(out, costs)) << "in place";
    });
  }
}

TEST(KeepGuided, DropsWinnersOutsideOfTheirRange) {
  const std::vector<Candidates> guide{{3, 5}, {3, 5}, {3, 5}, {3, 5}, {5, 3}, {}, {3, 5}};
  std::vector<std::int16_t> winners{2, 3, 5, 6, 4, 200, kNoWinner};
  keep_guided(guide, winners);
  EXPECT_EQ(winners,
            (std::vector<std::int16_t>{kNoWinner, 3, 5, kNoWinner, kNoWinner, 200, kNoWinner}));
  std::vector<std::int16_t> free{2, kNoWinner};
  keep_guided({}, free);
  EXPECT_EQ(free, (std::vector<std::int16_t>{2, kNoWinner}));
}

TEST(Narrows, OnlyWhereACandidateIsLeftOut) {
  const auto one = [](Candidates may, int candidates) {
    return narrows(std::vector<Candidates>{{}, may, {}}, candidates);
  };
  EXPECT_FALSE(one({}, 256));
  EXPECT_FALSE(one({0, 63}, 64));
  EXPECT_TRUE(one({1, 63}, 64));
  EXPECT_TRUE(one({0, 62}, 64));
  EXPECT_FALSE(narrows({}, 64));
}

}  // namespace
}  // namespace stof::dsp
