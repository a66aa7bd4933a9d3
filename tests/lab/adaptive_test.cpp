#include "lab/block/adaptive.h"

#include <algorithm>
#include <cstdlib>
#include <vector>

#include <gtest/gtest.h>

#include "dsp/stereo/search/winner.h"
#include "lab/block/match_blocks.h"
#include "tests/support/guarded_memory.h"
#include "tests/support/guarded_part.h"
#include "tests/support/random.h"

namespace stof::lab {
namespace {

struct Grown {
  test::GuardedImage<std::uint8_t> edges;
  std::vector<Block> blocks;

  Grown(int width, int height)
      : edges(width, height, width), blocks(static_cast<std::size_t>(width * height)) {}
  ImageView<Block> view() { return {blocks.data(), edges.view().width(), edges.view().height()}; }
  Block at(int x, int y) { return view().at(x, y); }
  void grow(const AdaptiveParams& params) {
    const auto image = edges.view();
    test::GuardedPart<Integral> integral(
        [&](Arena& arena) { return Integral(image.width(), image.height(), arena); });
    grow_blocks(image, params, *integral, view());
  }
};

constexpr AdaptiveParams kCross{
    .shape = BlockShape::kCross, .max_width = 10, .max_height = 6, .min_size = 3};
constexpr AdaptiveParams kRegion{
    .shape = BlockShape::kRegion, .max_width = 10, .max_height = 6, .min_size = 3};

TEST(AdaptiveBlocks, WithoutEdgesTheyAreTheMaximumCutAtTheBorder) {
  for (const BlockShape shape : {BlockShape::kFixed, BlockShape::kCross, BlockShape::kRegion}) {
    Grown grown(40, 30);
    AdaptiveParams params = kRegion;
    params.shape = shape;
    grown.grow(params);
    EXPECT_EQ(grown.at(20, 15), (Block{5, 4, 3, 2}));
    EXPECT_EQ(grown.at(0, 29), (Block{0, 4, 3, 0}));
    EXPECT_EQ(grown.at(38, 1), (Block{5, 1, 1, 2}));
  }
}

TEST(AdaptiveBlocks, ACrossLooksAlongItsArmsOnly) {
  Grown grown(40, 30);
  grown.edges.view().at(17, 15) = 1;  // on the row of the centre, 3 to the left
  grown.edges.view().at(22, 13) = 1;  // beside the arms
  grown.grow(kCross);
  EXPECT_EQ(grown.at(20, 15), (Block{2, 4, 3, 2}));
}

TEST(AdaptiveBlocks, ARegionTakesInNoEdge) {
  Grown grown(40, 30);
  grown.edges.view().at(17, 15) = 1;
  grown.edges.view().at(23, 13) = 1;
  grown.grow(kRegion);
  // Left stops at 2. Up to row 13 first, then column 23 would bring in its edge.
  EXPECT_EQ(grown.at(20, 15), (Block{2, 2, 3, 2}));
}

TEST(AdaptiveBlocks, TheSmallBlockMayHoldEdges) {
  Grown grown(9, 9);
  for (int y = 0; y < 9; ++y) {
    std::ranges::fill(grown.edges.view().row(y), std::uint8_t{1});
  }
  grown.grow(kRegion);
  EXPECT_EQ(grown.at(4, 4), (Block{1, 1, 1, 1}));
  EXPECT_EQ(grown.at(0, 8), (Block{0, 1, 1, 0}));
}

TEST(AdaptiveBlocks, EdgesAreChangesInEitherDirection) {
  test::GuardedImage<std::uint8_t> grey(5, 4, 5, 100), edges(5, 4, 6, 9);
  for (int y = 0; y < 4; ++y) {
    grey.view().at(4, y) = 120;
  }
  mark_edges(grey.view(), 20, edges.view());
  EXPECT_EQ(std::vector<std::uint8_t>(edges.view().row(1).begin(), edges.view().row(1).end()),
            (std::vector<std::uint8_t>{0, 0, 0, 1, 1}));
  mark_edges(grey.view(), 21, edges.view());
  EXPECT_EQ(edges.view().at(3, 1), 0);
  EXPECT_TRUE(edges.padding_is(9));
}

// The meaning of match_blocks(), pixel by pixel.
std::int16_t plain_winner(ImageView<const std::uint8_t> left, ImageView<const std::uint8_t> right,
                          Block block, int x, int y, int min_disparity, int disparities) {
  int lowest = -1, highest = -1;
  std::int16_t winner = kNoWinner;
  for (int i = 0; i < disparities; ++i) {
    const int d = min_disparity + i;
    if (x - d < 0 || x - d >= left.width()) {
      continue;
    }
    int sum = 0;
    for (int v = y - block.up; v <= y + block.down; ++v) {
      for (int u = x - block.left; u <= x + block.right; ++u) {
        sum += std::abs(left.at(u, v) - right.at(std::clamp(u - d, 0, left.width() - 1), v));
      }
    }
    winner = lowest < 0 || sum < lowest ? static_cast<std::int16_t>(i) : winner;
    lowest = lowest < 0 ? sum : std::min(lowest, sum);
    highest = std::max(highest, sum);
  }
  return lowest == highest ? kNoWinner : winner;
}

TEST(MatchBlocks, FindsTheLowestMeanCostOfEveryBlock) {
  for (const int min_disparity : {-3, 0, 2}) {
    for (const int width : {1, 7, 30}) {
      const int height = 11, disparities = 9;
      test::GuardedImage<std::uint8_t> left(width, height, width + 1), right(width, height, width);
      test::Random random(static_cast<std::uint64_t>(width + min_disparity));
      for (int y = 0; y < height; ++y) {
        random.fill(left.view().row(y), 0, 255);
        random.fill(right.view().row(y), 0, 255);
      }
      Grown grown(width, height);
      mark_edges(left.view(), 150, grown.edges.view());
      grown.grow(kRegion);
      std::vector<std::int16_t> winners(grown.blocks.size()), right_winners(grown.blocks.size());
      test::GuardedPart<BlockOffers> offers(
          [&](Arena& arena) { return BlockOffers(width, height, arena); });
      match_blocks(left.view(), right.view(), grown.view(), min_disparity, disparities, *offers,
                   {winners.data(), width, height}, {right_winners.data(), width, height});
      for (int y = 0; y < height; ++y) {
        for (int x = 0; x < width; ++x) {
          ASSERT_EQ(winners[static_cast<std::size_t>(y * width + x)],
                    plain_winner(left.view(), right.view(), grown.at(x, y), x, y, min_disparity,
                                 disparities))
              << x << ", " << y;
        }
      }
      check_blocks(ImageView<const std::int16_t>(right_winners.data(), width, height),
                   min_disparity, 0, {winners.data(), width, height});
    }
  }
}

TEST(MatchBlocks, AMovedPictureIsFoundAndItsOccludedPartIsDropped) {
  const int width = 60, height = 24, shift = 6;
  test::GuardedImage<std::uint8_t> left(width, height, width), right(width, height, width);
  test::Random random(5);
  for (int y = 0; y < height; ++y) {
    random.fill(left.view().row(y), 0, 255);
    random.fill(right.view().row(y), 0, 255);
    std::copy_n(left.view().row(y).data() + shift, width - shift, right.view().row(y).data());
  }
  Grown grown(width, height);
  grown.grow({.shape = BlockShape::kFixed, .max_width = 7, .max_height = 7});
  std::vector<std::int16_t> winners(grown.blocks.size()), right_winners(grown.blocks.size());
  test::GuardedPart<BlockOffers> offers(
      [&](Arena& arena) { return BlockOffers(width, height, arena); });
  match_blocks(left.view(), right.view(), grown.view(), 0, 12, *offers,
               {winners.data(), width, height}, {right_winners.data(), width, height});
  check_blocks(ImageView<const std::int16_t>(right_winners.data(), width, height), 0, 0,
               {winners.data(), width, height});
  int kept = 0;
  for (int x = 0; x < width; ++x) {
    const std::int16_t winner = winners[static_cast<std::size_t>(12 * width + x)];
    if (x >= shift + 3) {
      EXPECT_EQ(winner, shift) << x;
    } else if (x < shift) {
      kept += winner != kNoWinner ? 1 : 0;
    }
  }
  EXPECT_LT(kept, shift);
}

}  // namespace
}  // namespace stof::lab
