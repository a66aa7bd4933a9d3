#include "dsp/stereo/search/block_winners.h"

#include <algorithm>
#include <array>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "dsp/base/index.h"
#include "tests/support/kernel_check.h"

namespace stof::dsp {
namespace {

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

// A few rows, one after the other: one enters the block and one leaves it for each step.
void expect_equals_reference(const Case& of) {
  SCOPED_TRACE(name_of(of));
  test::check_kernel(std::array{index(of.width)}, [&](test::KernelCase& c) {
    const std::size_t n = index(of.width + of.row.block_width - 1), lanes = index(of.row.lanes);
    const auto columns = c.array<std::uint16_t>(n * lanes, 0, 0);
    const auto costs = c.array<std::uint16_t>(index(of.width) * lanes + 2 * kBlockCostMargin);
    const auto inner = costs.subspan(kBlockCostMargin, index(of.width) * lanes);
    struct Pixels {
      std::span<const std::uint8_t> left, right;
    };
    std::vector<Pixels> rows;
    for (int y = 0; y < of.block_height; ++y) {
      rows.push_back({c.array<std::uint8_t>(n, 0, 0), c.array<std::uint8_t>(n + lanes - 1, 0, 0)});
    }
    const int steps = (of.block_height + 2) | 1;  // odd: no second wrong bit takes back the first
    for (int y = 0; y < steps; ++y) {
      rows.push_back({c.array<std::uint8_t>(n, 0, of.largest),
                      c.array<std::uint8_t>(n + lanes - 1, 0, of.largest)});
    }
    for (std::size_t y = 0; y + index(of.block_height) < rows.size(); ++y) {
      const Pixels& entering = rows[y + index(of.block_height)];
      const BlockPixels pixels{entering.left, entering.right, rows[y].left, rows[y].right};
      const auto winners = c.array<std::int16_t>(index(of.width));
      const auto fitted = c.array<Disparity>(index(of.width));
      const auto margins = c.array<std::int16_t>(of.costs && y % 2 == 0 ? winners.size() : 0);
      c.run([&] {
        best::block_winners(
            pixels, of.row, columns,
            {winners, fitted, inner.first(of.costs ? inner.size() : 0), margins, y % 4 < 2});
      });
    }
  });
}

constexpr CostFit kFits[] = {CostFit::kNone, CostFit::kEquiangular, CostFit::kParabola};

TEST(BlockWinners, EqualReferenceForAllSizes) {
  unsigned turn = 0;
  for (const int lanes : {16, 32, 48, 64, 80, 96, 128, 256}) {
    for (const int width : {1, 2, 7, 8, 31, 32, 33, 70}) {
      for (const int block : {1, 2, 5, 15}) {
        for (const bool costs : {false, true}) {
          Case c{.row = {.block_width = block,
                         .lanes = lanes,
                         .disparities = lanes - (width % 3 == 0 ? 5 : 0),
                         .x = 300,
                         .right_width = 400,
                         .fit = kFits[turn++ % 3]},
                 .width = width,
                 .block_height = block,
                 .largest = 30,
                 .costs = costs};
          expect_equals_reference(c);
          c.row.x = 0;  // the border
          expect_equals_reference(c);
        }
      }
    }
  }
}

TEST(BlockWinners, EqualReferenceWhereTheRightPictureEnds) {
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
          expect_equals_reference(c);
        }
      }
    }
  }
}

// Few different costs: many ties, and rows where no candidate costs more than another.
TEST(BlockWinners, EqualReferenceInTiesAndFlatRows) {
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
        expect_equals_reference(c);
      }
    }
  }
}

TEST(BlockWinners, EqualReferenceAtTheLargestSumsAndPixels) {
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
    expect_equals_reference(c);
    c.row.block_width = 10;
    c.block_height = 6;
    c.largest = kLargestBlockPixel;
    ASSERT_TRUE(block_winners_serve(c.row.block_width, c.block_height, c.largest));
    expect_equals_reference(c);
  }
}

// One candidate matches at once, all others cost the most there is: the steepest fits.
TEST(BlockWinners, SteepestFitsEqualReference) {
  for (const CostFit fit : kFits) {
    const BlockRow row{
        .block_width = 16, .lanes = 32, .disparities = 32, .x = 40, .right_width = 200, .fit = fit};
    const std::size_t n = 40;
    std::vector<std::uint8_t> left(n, 0), right(n + 31, 30);
    std::fill(right.begin() + 20, right.begin() + 51, std::uint8_t{0});
    test::check_kernel(std::array{n}, [&](test::KernelCase& c) {
      const auto columns = c.array<std::uint16_t>(n * 32, 0, 0);
      const auto winners = c.array<std::int16_t>(n - 15);
      const auto fitted = c.array<Disparity>(n - 15);
      const std::vector<std::uint8_t> none_left(n, 0), none_right(n + 31, 0);
      c.run([&] {
        for (int y = 0; y < 16; ++y) {
          best::block_winners({left, right, none_left, none_right}, row, columns,
                              {winners, fitted, {}, {}});
        }
        best::block_winners({left, right, left, right}, row, columns, {winners, fitted, {}, {}});
      });
    });
  }
}

}  // namespace
}  // namespace stof::dsp
