#include "dsp/stereo/search/block_winners.h"

#include <algorithm>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "tests/support/guarded.h"
#include "tests/support/random.h"
#include "tests/support/vectors.h"

namespace stof::dsp {
namespace {

std::size_t size(int value) { return static_cast<std::size_t>(value); }

// Rows of pixels: one that enters and one that leaves for each step.
struct Pixels {
  std::vector<std::uint8_t> left;
  std::vector<std::uint8_t> right;
};

Pixels pixels_of(test::Random& random, std::size_t n, int lanes, int largest) {
  Pixels pixels{std::vector<std::uint8_t>(n), std::vector<std::uint8_t>(n + size(lanes) - 1)};
  random.fill(std::span(pixels.left), 0, largest);
  random.fill(std::span(pixels.right), 0, largest);
  return pixels;
}

struct Case {
  BlockRow row;
  int width = 0;  // columns of matches
  int block_height = 1;
  int largest = 0;  // pixel
  bool costs = false;
};

std::string name_of(const Case& c) {
  return std::to_string(c.row.lanes) + " lanes, " + std::to_string(c.row.disparities) +
         " candidates from " + std::to_string(c.row.min_disparity) + ", " +
         std::to_string(c.width) + " columns from " + std::to_string(c.row.x) + " of " +
         std::to_string(c.row.right_width) + ", block " + std::to_string(c.row.block_width) +
         " x " + std::to_string(c.block_height) + ", fit " +
         std::to_string(static_cast<int>(c.row.fit)) + (c.costs ? ", costs" : "");
}

// What came of a few rows, one after the other.
struct Result {
  std::vector<std::uint16_t> columns;
  std::vector<std::int16_t> winners;
  std::vector<Disparity> fitted;
  std::vector<std::uint16_t> costs;
};

template <typename Function>
Result run(const Case& c, std::uint64_t seed, Function&& block_winners) {
  const std::size_t n = size(c.width + c.row.block_width - 1);
  const std::size_t lanes = size(c.row.lanes);
  test::Random random(seed);
  std::vector<Pixels> rows(size(c.block_height), Pixels{std::vector<std::uint8_t>(n),
                                                        std::vector<std::uint8_t>(n + lanes - 1)});
  Result result;
  test::GuardedBuffer<std::uint16_t> columns(n * lanes);
  test::GuardedBuffer<std::int16_t> winners(size(c.width));
  test::GuardedBuffer<Disparity> fitted(size(c.width));
  std::vector<std::uint16_t> costs(size(c.width) * lanes + 2 * kBlockCostMargin, 12345);
  const std::span<std::uint16_t> inner =
      std::span(costs).subspan(kBlockCostMargin, size(c.width) * lanes);
  std::ranges::fill(columns.span(), std::uint16_t{0});
  for (std::size_t y = 0; y < size(c.block_height) + 2; ++y) {
    const Pixels entering = pixels_of(random, n, c.row.lanes, c.largest);
    Pixels& leaving = rows[y % rows.size()];
    block_winners(
        BlockPixels{entering.left, entering.right, leaving.left, leaving.right}, c.row,
        columns.span(),
        BlockMatches{winners.span(), fitted.span(), c.costs ? inner : std::span<std::uint16_t>{}});
    leaving = entering;
    result.winners.insert(result.winners.end(), winners.span().begin(), winners.span().end());
    result.fitted.insert(result.fitted.end(), fitted.span().begin(), fitted.span().end());
    if (c.costs) {
      result.costs.insert(result.costs.end(), costs.begin(), costs.end());
    }
  }
  result.columns.assign(columns.span().begin(), columns.span().end());
  return result;
}

void expect_equal(const Case& c, std::uint64_t seed) {
  const Result expected = run(c, seed, [](auto&&... all) { ref::block_winners(all...); });
  for (const Vectors vectors : test::all_vectors()) {
    const test::UseVectors use(vectors);
    const Result got = run(c, seed, [](auto&&... all) { best::block_winners(all...); });
    ASSERT_EQ(expected.columns, got.columns) << name_of(c);
    ASSERT_EQ(expected.costs, got.costs) << name_of(c);
    ASSERT_EQ(expected.winners, got.winners) << name_of(c);
    ASSERT_TRUE(std::ranges::equal(expected.fitted, got.fitted)) << name_of(c);
  }
}

constexpr CostFit kFits[] = {CostFit::kNone, CostFit::kEquiangular, CostFit::kParabola};

TEST(BlockWinners, EqualTheReferenceForAllSizes) {
  std::uint64_t seed = 0;
  for (const int lanes : {16, 32, 48, 64, 80, 96, 128, 256}) {
    for (const int width : {1, 2, 7, 8, 31, 32, 33, 70}) {
      for (const int block : {1, 2, 5, 15}) {
        for (const bool costs : {false, true}) {
          Case c{.row = {.block_width = block,
                         .lanes = lanes,
                         .disparities = lanes - (width % 3 == 0 ? 5 : 0),
                         .x = 300,
                         .right_width = 400,
                         .fit = kFits[seed % 3]},
                 .width = width,
                 .block_height = block,
                 .largest = 30,
                 .costs = costs};
          expect_equal(c, ++seed);
          c.row.x = 0;  // the border
          expect_equal(c, ++seed);
        }
      }
    }
  }
}

TEST(BlockWinners, MeetsOnlyColumnsOfTheRightPicture) {
  std::uint64_t seed = 1000;
  for (const int min_disparity : {-70, -3, 0, 4, 90}) {
    for (const int x : {0, 5, 60}) {
      for (const int right_width : {1, 20, 64, 100}) {
        for (const bool costs : {false, true}) {
          const Case c{.row = {.block_width = 3,
                               .lanes = 64,
                               .disparities = 61,
                               .min_disparity = min_disparity,
                               .x = x,
                               .right_width = right_width,
                               .fit = CostFit::kParabola},
                       .width = 45,
                       .block_height = 3,
                       .largest = 15,
                       .costs = costs};
          expect_equal(c, ++seed);
        }
      }
    }
  }
}

// Few different costs: many ties, and rows where no candidate costs more than another.
TEST(BlockWinners, TiesGoToTheSmallestCandidateAndFlatRowsToNone) {
  std::uint64_t seed = 2000;
  for (const int largest : {0, 1, 2}) {
    for (const int lanes : {16, 64, 96, 128}) {
      for (const int x : {0, 200}) {
        const Case c{.row = {.block_width = 1 + largest,
                             .lanes = lanes,
                             .disparities = lanes,
                             .x = x,
                             .right_width = 400,
                             .fit = CostFit::kEquiangular},
                     .width = 75,
                     .block_height = 1,
                     .largest = largest};
        expect_equal(c, ++seed);
      }
    }
  }
}

TEST(BlockWinners, LargestSumsAndPixelsFit) {
  std::uint64_t seed = 3000;
  for (const CostFit fit : kFits) {
    Case c{.row = {.block_width = 16,
                   .lanes = 64,
                   .disparities = 64,
                   .x = 64,
                   .right_width = 200,
                   .fit = fit},
           .width = 50,
           .block_height = 16,
           .largest = 30};
    ASSERT_TRUE(block_winners_serve(c.row.block_width, c.block_height, c.largest));
    expect_equal(c, ++seed);
    c.row.block_width = 10;
    c.block_height = 6;
    c.largest = kLargestBlockPixel;
    ASSERT_TRUE(block_winners_serve(c.row.block_width, c.block_height, c.largest));
    expect_equal(c, ++seed);
  }
}

// One candidate matches at once, all others cost the most there is: the steepest fits.
TEST(BlockWinners, SteepestFitsEqualTheReference) {
  for (const CostFit fit : kFits) {
    const BlockRow row{
        .block_width = 16, .lanes = 32, .disparities = 32, .x = 40, .right_width = 200, .fit = fit};
    const std::size_t n = 40;
    std::vector<std::uint8_t> left(n, 0), right(n + 31, 30);
    std::fill(right.begin() + 20, right.begin() + 51, std::uint8_t{0});
    for (const Vectors vectors : test::all_vectors()) {
      const test::UseVectors use(vectors);
      std::vector<std::uint16_t> expected_columns(n * 32, 0), columns(n * 32, 0);
      std::vector<std::int16_t> expected(n - 15), winners(n - 15);
      std::vector<Disparity> expected_fitted(n - 15), fitted(n - 15);
      const std::vector<std::uint8_t> none_left(n, 0), none_right(n + 31, 0);
      for (int y = 0; y < 16; ++y) {
        const BlockPixels pixels{left, right, none_left, none_right};
        ref::block_winners(pixels, row, expected_columns, {expected, expected_fitted, {}});
        best::block_winners(pixels, row, columns, {winners, fitted, {}});
      }
      EXPECT_EQ(expected, winners);
      EXPECT_TRUE(std::ranges::equal(expected_fitted, fitted));
    }
  }
}

}  // namespace
}  // namespace stof::dsp
