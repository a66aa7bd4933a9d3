#include "dsp/stereo/search/path_costs.h"

#include <algorithm>
#include <array>
#include <vector>

#include <gtest/gtest.h>

#include "tests/support/kernel_check.h"
#include "tests/support/random.h"

namespace stof::dsp {
namespace {

constexpr std::array<std::size_t, 4> kColumns{1, 2, 3, 17};

template <typename Cost>
class Path : public testing::Test {
 protected:
  static constexpr int kLanes = 16;
  // Rows of 16 candidates: those named, then none.
  static std::vector<Cost> rows(std::initializer_list<std::initializer_list<int>> pixels) {
    std::vector<Cost> out;
    for (const auto& pixel : pixels) {
      const std::size_t begin = out.size();
      out.resize(begin + kLanes, kNoCost<Cost>);
      std::ranges::transform(pixel, out.begin() + static_cast<std::ptrdiff_t>(begin),
                             [](int cost) { return static_cast<Cost>(cost); });
    }
    return out;
  }
  // Any values, with some missing candidates; low ones, so that minima tie, or the whole range.
  static std::span<Cost> costs(test::KernelCase& c, std::size_t count, bool whole_range) {
    const auto out =
        c.array<Cost>(count, 0, whole_range ? static_cast<int>(kNoCost<Cost> / 2) : 60);
    for (Cost& cost : out) {
      if (c.random().between(0, 9) == 0) {
        cost = kNoCost<Cost>;
      } else if (whole_range && c.random().between(0, 1) == 0) {
        cost = static_cast<Cost>(kNoCost<Cost> - cost);
      }
    }
    return out;
  }
};
using Costs = testing::Types<std::uint8_t, std::uint16_t, std::uint32_t>;
TYPED_TEST_SUITE(Path, Costs);

TYPED_TEST(Path, StaysStepsOrJumpsWhicheverCostsLeast) {
  using Cost = TypeParam;
  const std::vector<Cost> costs = this->rows({{9, 2, 30, 30, 30}, {5, 5, 5, 5, 5}});
  const std::vector<Cost> large{20, 20};
  std::vector<Cost> paths(32);
  best::paths_along(std::span<const Cost>(costs), 16, Cost{3}, std::span<const Cost>(large), true,
                    std::span<Cost>(paths));
  // Before: minimum 2 at candidate 1. A step from it costs 3, anything farther 20.
  const std::vector<Cost> expected =
      this->rows({{9, 2, 30, 30, 30}, {5 + 3, 5 + 0, 5 + 3, 5 + 20, 5 + 20}});
  EXPECT_EQ(paths, expected);
}

TYPED_TEST(Path, FromTheRightUsesThePenaltyOfThePixelItEnters) {
  using Cost = TypeParam;
  const std::vector<Cost> costs = this->rows({{5, 5, 5, 5}, {7, 7, 7, 1}});
  const std::vector<Cost> large{4, 9};
  std::vector<Cost> paths(32);
  best::paths_along(std::span<const Cost>(costs), 16, Cost{2}, std::span<const Cost>(large), false,
                    std::span<Cost>(paths));
  EXPECT_EQ(paths, this->rows({{5 + 4, 5 + 4, 5 + 2, 5 + 0}, {7, 7, 7, 1}}));
}

TYPED_TEST(Path, DiagonalsTakeTheirOwnColumnAndStartAtTheBorder) {
  using Cost = TypeParam;
  const std::vector<Cost> costs = this->rows({{1, 1}, {1, 1}, {1, 1}});
  const std::vector<Cost> before = this->rows({{0, 9}, {9, 0}, {0, 5}});
  const std::vector<Cost> large{7, 7, 7};
  std::vector<Cost> paths(48);
  const auto run = [&](int shift) {
    best::paths_across(std::span<const Cost>(costs), std::span<const Cost>(before), shift, 16,
                       Cost{3}, std::span<const Cost>(large), std::span<Cost>(paths));
    return paths;
  };
  EXPECT_EQ(run(0), this->rows({{1, 4}, {4, 1}, {1, 4}}));
  EXPECT_EQ(run(1), this->rows({{1, 1}, {1, 4}, {4, 1}}));   // column 0 starts
  EXPECT_EQ(run(-1), this->rows({{4, 1}, {1, 4}, {1, 1}}));  // the last column starts
}

TYPED_TEST(Path, WhatIsOutsideStaysOutsideAndAnEmptyPixelStartsAnew) {
  using Cost = TypeParam;
  const std::vector<Cost> costs = this->rows({{4, 200}, {}, {6, 2}});
  const std::vector<Cost> large{30, 30, 30};
  std::vector<Cost> paths(48);
  best::paths_along(std::span<const Cost>(costs), 16, Cost{10}, std::span<const Cost>(large), true,
                    std::span<Cost>(paths));
  EXPECT_EQ(paths, costs);
}

TYPED_TEST(Path, EqualsReferenceAlongRows) {
  using Cost = TypeParam;
  for (int lanes = 16; lanes <= 256; lanes += 16) {
    for (const bool whole_range : {false, true}) {
      test::check_kernel(kColumns, [&](test::KernelCase& c) {
        const std::size_t n = c.length(), count = n * static_cast<std::size_t>(lanes);
        const auto costs = this->costs(c, count, whole_range);
        const auto large = c.array<Cost>(n, 9, whole_range ? 250 : 60);
        const auto other = c.array<Cost>(n, 9, 200);
        const auto left = c.array<Cost>(count), right = c.array<Cost>(count);
        c.run([&] { best::paths_along(costs, lanes, Cost{9}, large, true, left); });
        c.run([&] { best::paths_along(costs, lanes, Cost{9}, large, false, right); });
        const auto both_left = c.array<Cost>(count), both_right = c.array<Cost>(count);
        c.run([&] {
          best::paths_both_ways(costs, lanes, Cost{9}, other, large, both_left, both_right);
        });
        ASSERT_TRUE(std::ranges::equal(right, both_right));
        c.run([&] { best::paths_along(costs, lanes, Cost{9}, large, false, costs); });
        ASSERT_TRUE(std::ranges::equal(right, costs)) << "in place";
      });
    }
  }
}

TYPED_TEST(Path, EqualsReferenceAcrossRows) {
  using Cost = TypeParam;
  for (int lanes = 16; lanes <= 256; lanes += 16) {
    for (const int shift : {-1, 0, 1}) {
      test::check_kernel(kColumns, [&](test::KernelCase& c) {
        const std::size_t n = c.length(), count = n * static_cast<std::size_t>(lanes);
        const auto costs = this->costs(c, count, n == 17);
        const auto before = this->costs(c, count, n == 17);
        const auto large = c.array<Cost>(n, 9, 250);
        const auto paths = c.array<Cost>(count);
        const auto across = [&](std::span<Cost> out) {
          best::paths_across(costs, before, shift, lanes, Cost{9}, large, out);
        };
        c.run([&] { across(paths); });
        if (shift == 0) {
          c.run([&] { across(before); });
          ASSERT_TRUE(std::ranges::equal(paths, before)) << "in place";
        }
      });
    }
  }
}

TYPED_TEST(Path, EqualsReferenceOfBothAxes) {
  using Cost = TypeParam;
  if constexpr (sizeof(Cost) <= 2) {
    for (int lanes = 16; lanes <= 256; lanes += 16) {
      for (const unsigned how : {0U, 1U, 2U, 3U, 4U, 5U, 6U, 7U}) {
        test::check_kernel(kColumns, [&](test::KernelCase& c) {
          const std::size_t n = c.length(), count = n * static_cast<std::size_t>(lanes);
          const auto costs = this->costs(c, count, n == 17);
          const auto front = this->costs(c, count, n == 17);
          const auto sums = this->costs(c, count, n == 17);  // of other directions
          const auto along = c.array<Cost>(n, 9, 60), across = c.array<Cost>(n, 9, 200);
          const AxesRow<Cost> row{.costs = costs,
                                  .lanes = lanes,
                                  .small = Cost{9},
                                  .from_left = (how & 1) != 0,
                                  .large_along = along,
                                  .large_across = across.first((how & 2) != 0 ? n : 0)};
          c.run([&] {
            best::paths_of_axes(row, front, sums.first((how & 4) != 0 ? count : 0), sums);
          });
        });
      }
    }
  }
}

TYPED_TEST(Path, BothAxesAreThePathsOfEachAndTheirSum) {
  using Cost = TypeParam;
  if constexpr (sizeof(Cost) <= 2) {
    test::Random random(4);
    const std::size_t n = 9, count = n * 32;
    std::vector<Cost> costs(count), front(count), large(n, 30), across(n, 50), sums(count);
    std::vector<Cost> along(count), down(count);
    random.fill(std::span(costs), 0, 30);
    random.fill(std::span(front), 0, 60);
    best::paths_along(std::span<const Cost>(costs), 32, Cost{5}, std::span<const Cost>(large), true,
                      std::span(along));
    best::paths_across(std::span<const Cost>(costs), std::span<const Cost>(front), 0, 32, Cost{5},
                       std::span<const Cost>(across), std::span(down));
    const AxesRow<Cost> row{.costs = costs,
                            .lanes = 32,
                            .small = Cost{5},
                            .from_left = true,
                            .large_along = large,
                            .large_across = across};
    best::paths_of_axes(row, std::span(front), {}, std::span(sums));
    EXPECT_EQ(front, down);
    for (std::size_t i = 0; i < count; ++i) {
      ASSERT_EQ(sums[i], along[i] + down[i]);
    }
  }
}

TYPED_TEST(Path, RowWithoutColumnsIsLeftAlone) {
  using Cost = TypeParam;
  const std::span<Cost> none;
  best::paths_along(none, 16, Cost{1}, none, true, none);
  best::paths_both_ways(none, 16, Cost{1}, none, none, none, none);
  best::paths_across(none, none, 0, 16, Cost{1}, none, none);
}

}  // namespace
}  // namespace stof::dsp
