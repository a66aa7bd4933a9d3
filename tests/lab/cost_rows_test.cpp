#include "lab/cost/cost_rows.h"

#include <algorithm>
#include <array>
#include <cstdlib>
#include <vector>

#include <gtest/gtest.h>

#include "dsp/stereo/cost/ad_census.h"
#include "dsp/stereo/cost/sad.h"
#include "tests/support/guarded_memory.h"
#include "tests/support/random.h"

namespace stof::lab {
namespace {

constexpr std::array kCosts{Cost::kSad, Cost::kSsd, Cost::kCensus5x5, Cost::kCensus9x7,
                            Cost::kAdCensus};

struct Pair {
  test::GuardedImage<std::uint8_t> left, right;

  Pair(int width, int height, std::uint64_t seed)
      : left(width, height, width + 3), right(width, height, width) {
    test::Random random(seed);
    for (test::GuardedImage<std::uint8_t>* const image : {&left, &right}) {
      fill(*image, random);
    }
  }
  CostPictures pictures() { return {left.view(), right.view()}; }
  static void fill(test::GuardedImage<std::uint8_t>& image, test::Random& random) {
    for (int y = 0; y < image.view().height(); ++y) {
      random.fill(image.view().row(y));
    }
  }
};

using Picture = ImageView<const std::uint8_t>;

int at(Picture picture, int x, int y) {
  return picture.row_clamped(y)[static_cast<std::size_t>(std::clamp(x, 0, picture.width() - 1))];
}

// Horizontal Sobel, clipped at 20.
int derivative_at(Picture picture, int x, int y) {
  int sum = 0;
  for (int dy = -1; dy <= 1; ++dy) {
    sum += (dy == 0 ? 2 : 1) * (at(picture, x + 1, y + dy) - at(picture, x - 1, y + dy));
  }
  return std::clamp(sum, -20, 20);
}

// chessboard: of the neighbours an odd number of steps away alone.
int hamming(Picture left, Picture right, int xl, int xr, int y, int reach_x, int reach_y,
            bool chessboard = false) {
  int distance = 0;
  for (int dy = -reach_y; dy <= reach_y; ++dy) {
    for (int dx = -reach_x; dx <= reach_x; ++dx) {
      if (chessboard && (dx + dy) % 2 == 0) {
        continue;
      }
      const bool l = at(left, xl + dx, y + dy) < at(left, xl, y);
      const bool r = at(right, xr + dx, y + dy) < at(right, xr, y);
      distance += l != r ? 1 : 0;
    }
  }
  return distance;
}

// What left (xl, y) and right (xr, y), all inside, differ by.
int pixel_cost(const CostPictures& p, Cost cost, int xl, int xr, int y) {
  const int grey = std::abs(at(p.left, xl, y) - at(p.right, xr, y));
  switch (cost) {
    case Cost::kSad:
      return grey;
    case Cost::kSsd:
      return grey * grey;
    case Cost::kCensus5x5:
      return hamming(p.left, p.right, xl, xr, y, 2, 2);
    case Cost::kCensus9x7:
      return hamming(p.left, p.right, xl, xr, y, 4, 3);
    case Cost::kAdCensus:
      break;
  }
  const int derivative = std::abs(derivative_at(p.left, xl, y) - derivative_at(p.right, xr, y));
  return 2 * hamming(p.left, p.right, xl, xr, y, 3, 3, true) +
         (std::min(grey, kAdCensusGreyCap) + std::min(derivative, kAdCensusDerivativeCap)) / 2;
}

// The formula of the header, from a table of what each pixel of a row differs by from each other.
class BruteForce {
 public:
  BruteForce(const CostPictures& pictures, const MatchParams& params)
      : params_(params), width_(pictures.left.width()), height_(pictures.left.height()) {
    for (int y = 0; y < height_; ++y) {
      for (int xl = 0; xl < width_; ++xl) {
        for (int xr = 0; xr < width_; ++xr) {
          table_.push_back(pixel_cost(pictures, params.cost, xl, xr, y));
        }
      }
    }
  }
  bool offered(int x, int candidate) const {
    const int right = x - params_.min_disparity - candidate;
    return candidate < params_.disparities && right >= 0 && right < width_;
  }
  std::uint32_t block(int x, int y, int candidate) const {
    const int left = -(params_.block_width / 2), top = -(params_.block_height / 2);
    const int disparity = params_.min_disparity + candidate;
    std::uint32_t sum = 0;
    for (int yy = y + top; yy < y + top + params_.block_height; ++yy) {
      for (int xx = x + left; xx < x + left + params_.block_width; ++xx) {
        sum += static_cast<std::uint32_t>(cost(xx, xx - disparity, yy));
      }
    }
    return sum;
  }

 private:
  int cost(int xl, int xr, int y) const {
    const int row = std::clamp(y, 0, height_ - 1) * width_ + std::clamp(xl, 0, width_ - 1);
    return table_[static_cast<std::size_t>(row * width_ + std::clamp(xr, 0, width_ - 1))];
  }
  MatchParams params_;
  int width_;
  int height_;
  std::vector<int> table_;
};

// A CostRows with memory that ends at an unreadable page.
struct Built {
  test::GuardedBuffer<std::byte> memory;
  Arena arena;
  CostRows rows;
  Built(const MatchParams& params, int width)
      : memory(bytes_taken([&](Arena& measuring) { CostRows(params, width, measuring); })),
        arena(memory.span()),
        rows(params, width, arena) {}

  std::vector<std::uint32_t> row(const MatchParams& params, int y) {
    if (CostRows::wide(params)) {
      const std::span<const std::uint32_t> costs = rows.row<std::uint32_t>(y);
      return {costs.begin(), costs.end()};
    }
    std::vector<std::uint32_t> costs;
    for (const std::uint16_t cost : rows.row<std::uint16_t>(y)) {
      costs.push_back(cost == kNoCost<std::uint16_t> ? kNoCost<std::uint32_t> : cost);
    }
    return costs;
  }
};

void expect_formula(const MatchParams& params, Pair& pair) {
  const CostPictures pictures = pair.pictures();
  const int width = pictures.left.width();
  const BruteForce formula(pictures, params);
  Built built(params, width);
  built.rows.start(pictures);
  for (int y = 0; y < pictures.left.height(); ++y) {
    const std::vector<std::uint32_t> costs = built.row(params, y);
    const int lanes = built.rows.lanes();
    ASSERT_EQ(costs.size(), static_cast<std::size_t>(width * lanes));
    for (int x = 0; x < width; ++x) {
      for (int i = 0; i < lanes; ++i) {
        ASSERT_EQ(costs[static_cast<std::size_t>(x * lanes + i)],
                  formula.offered(x, i) ? formula.block(x, y, i) : kNoCost<std::uint32_t>)
            << "cost " << static_cast<int>(params.cost) << " x " << x << " y " << y << " candidate "
            << i << " of " << width << "x" << pictures.left.height() << " block "
            << params.block_width << "x" << params.block_height << " from " << params.min_disparity;
      }
    }
  }
}

MatchParams with(Cost cost, int min_disparity, int disparities, int block_width, int block_height) {
  MatchParams params;
  params.cost = cost;
  params.min_disparity = min_disparity;
  params.disparities = disparities;
  params.block_width = block_width;
  params.block_height = block_height;
  params.prefilter_cap.reset();
  return params;
}

TEST(CostRows, AreTheFormulaForEveryCostAndBlock) {
  Pair pair(29, 13, 1);
  for (const Cost cost : kCosts) {
    expect_formula(with(cost, 0, 16, 1, 1), pair);
    expect_formula(with(cost, -3, 20, 3, 3), pair);
    expect_formula(with(cost, 2, 17, 4, 7), pair);
    expect_formula(with(cost, -9, 5, 16, 2), pair);
  }
}

TEST(CostRows, AreTheFormulaForPicturesSmallerThanTheBlock) {
  for (const Cost cost : kCosts) {
    for (const int width : {1, 2, 5, 16}) {
      for (const int height : {1, 2, 6}) {
        Pair pair(width, height, static_cast<std::uint64_t>(width * 10 + height));
        expect_formula(with(cost, -1, 3, 5, 4), pair);
      }
    }
    Pair pair(5, 3, 4);
    expect_formula(with(cost, 0, 4, 64, 64), pair);
    expect_formula(with(cost, -2, 4, 30, 10), pair);
    expect_formula(with(cost, 1, 2, 1, 64), pair);
  }
}

TEST(CostRows, OfferNothingWhereTheRangeMissesTheRightPicture) {
  for (const Cost cost : kCosts) {
    Pair pair(7, 3, 5);
    for (const int min_disparity : {7, 1024, -1024, -22}) {
      const MatchParams params = with(cost, min_disparity, 16, 3, 3);
      expect_formula(params, pair);
      Built built(params, 7);
      built.rows.start(pair.pictures());
      const std::vector<std::uint32_t> costs = built.row(params, 1);
      EXPECT_TRUE(std::ranges::all_of(
          costs, [](std::uint32_t sum) { return sum == kNoCost<std::uint32_t>; }));
    }
  }
}

TEST(CostRows, DoNotDependOnTheOrderOfRows) {
  for (const Cost cost : kCosts) {
    const MatchParams params = with(cost, -2, 16, 5, 6);
    Pair pair(23, 11, 7);
    Built in_order(params, 23);
    in_order.rows.start(pair.pictures());
    std::vector<std::vector<std::uint32_t>> expected;
    for (int y = 0; y < 11; ++y) {
      expected.push_back(in_order.row(params, y));
    }
    // A picture wider than those that follow, and rows of another pair before them.
    Built any_order(params, 40);
    Pair other(40, 20, 8);
    any_order.rows.start(other.pictures());
    any_order.row(params, 19);
    any_order.rows.start(pair.pictures());
    for (const int y : {10, 3, 4, 5, 5, 4, 0, 1, 10, 9, 8, 7, 6, 7, 8}) {
      ASSERT_EQ(any_order.row(params, y), expected[static_cast<std::size_t>(y)])
          << "row " << y << " cost " << static_cast<int>(cost);
    }
  }
}

TEST(CostRows, NarrowSumsHoldTheLargestBlockTheyAreChosenFor) {
  // All bits, grey values and derivatives as far apart as they can be.
  for (const Cost cost : kCosts) {
    for (const int block : {1, 8, 16, 17, 32, 33, 64}) {
      MatchParams params = with(cost, 0, 1, block, block);
      Pair pair(3, 3, 9);
      for (int y = 0; y < 3; ++y) {
        std::ranges::fill(pair.left.view().row(y), std::uint8_t{255});
        std::ranges::fill(pair.right.view().row(y), std::uint8_t{0});
      }
      expect_formula(params, pair);
    }
  }
  EXPECT_FALSE(CostRows::wide(with(Cost::kSad, 0, 64, 16, 16)));
  EXPECT_TRUE(CostRows::wide(with(Cost::kSad, 0, 64, 17, 16)));
  EXPECT_FALSE(CostRows::wide(with(Cost::kSsd, 0, 64, 1, 1)));
  EXPECT_TRUE(CostRows::wide(with(Cost::kSsd, 0, 64, 2, 1)));
  EXPECT_FALSE(CostRows::wide(with(Cost::kCensus5x5, 0, 64, 52, 52)));
  EXPECT_TRUE(CostRows::wide(with(Cost::kCensus9x7, 0, 64, 33, 33)));
  MatchParams derivative = with(Cost::kSsd, 0, 64, 8, 8);
  derivative.prefilter_cap = 15;
  EXPECT_FALSE(CostRows::wide(derivative));
}

TEST(PixelCosts, AreSinglePixelsOfThePicturesOwnColumns) {
  for (const Cost cost : {Cost::kCensus5x5, Cost::kCensus9x7, Cost::kAdCensus}) {
    const MatchParams params = with(cost, -3, 16, 9, 9);
    Pair pair(20, 6, 10);
    const CostPictures pictures = pair.pictures();
    const PixelCost kind =
        cost == Cost::kAdCensus
            ? PixelCost::kAdCensus
            : (cost == Cost::kCensus5x5 ? PixelCost::kCensus5x5 : PixelCost::kCensus9x7);
    test::GuardedBuffer<std::byte> memory(
        bytes_taken([&](Arena& measuring) { PixelCosts(kind, params, 20, {}, measuring); }));
    Arena arena(memory.span());
    PixelCosts pixels(kind, params, 20, {}, arena);
    pixels.start(pictures);
    test::GuardedBuffer<std::uint8_t> costs(20 * 16);
    for (const int y : {5, 0, 3}) {
      pixels.row(y, costs.span());
      mark_outside(params, 20, costs.span());
      for (int x = 0; x < 20; ++x) {
        for (int i = 0; i < 16; ++i) {
          const int right = x + 3 - i;
          const int expected = right < 0 || right >= 20 ? kNoCost<std::uint8_t>
                                                        : pixel_cost(pictures, cost, x, right, y);
          ASSERT_EQ(costs[static_cast<std::size_t>(x * 16 + i)], expected) << x << " " << i;
        }
      }
    }
  }
}

}  // namespace
}  // namespace stof::lab
