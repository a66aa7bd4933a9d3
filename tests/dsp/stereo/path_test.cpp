#include "dsp/stereo/search/path.h"

#include <algorithm>
#include <vector>

#include <gtest/gtest.h>

#include "tests/support/guarded.h"
#include "tests/support/random.h"

namespace stof::dsp {
namespace {

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
  static void fill(std::span<Cost> out, test::Random& random, bool whole_range) {
    random.fill(out, 0, whole_range ? static_cast<int>(kNoCost<Cost> / 2) : 60);
    for (Cost& cost : out) {
      if (random.between(0, 9) == 0) {
        cost = kNoCost<Cost>;
      } else if (whole_range && random.between(0, 1) == 0) {
        cost = static_cast<Cost>(kNoCost<Cost> - cost);
      }
    }
  }
};
using Costs = testing::Types<std::uint8_t, std::uint16_t, std::uint32_t>;
TYPED_TEST_SUITE(Path, Costs);

TYPED_TEST(Path, StaysStepsOrJumpsWhicheverCostsLeast) {
  using Cost = TypeParam;
  const std::vector<Cost> costs = this->rows({{9, 2, 30, 30, 30}, {5, 5, 5, 5, 5}});
  const std::vector<Cost> large{20, 20};
  std::vector<Cost> paths(32);
  for (auto* const run : {static_cast<PathsAlong<Cost>*>(ref::paths_from_left),
                          static_cast<PathsAlong<Cost>*>(neon::paths_from_left)}) {
    run(std::span<const Cost>(costs), 16, Cost{3}, std::span<const Cost>(large),
        std::span<Cost>(paths));
    // Before: minimum 2 at candidate 1. A step from it costs 3, anything farther 20.
    const std::vector<Cost> expected =
        this->rows({{9, 2, 30, 30, 30}, {5 + 3, 5 + 0, 5 + 3, 5 + 20, 5 + 20}});
    EXPECT_EQ(paths, expected);
  }
}

TYPED_TEST(Path, FromTheRightUsesThePenaltyOfThePixelItEnters) {
  using Cost = TypeParam;
  const std::vector<Cost> costs = this->rows({{5, 5, 5, 5}, {7, 7, 7, 1}});
  const std::vector<Cost> large{4, 9};
  std::vector<Cost> paths(32);
  for (auto* const run : {static_cast<PathsAlong<Cost>*>(ref::paths_from_right),
                          static_cast<PathsAlong<Cost>*>(neon::paths_from_right)}) {
    run(std::span<const Cost>(costs), 16, Cost{2}, std::span<const Cost>(large),
        std::span<Cost>(paths));
    EXPECT_EQ(paths, this->rows({{5 + 4, 5 + 4, 5 + 2, 5 + 0}, {7, 7, 7, 1}}));
  }
}

TYPED_TEST(Path, DiagonalsTakeTheirOwnColumnAndStartAtTheBorder) {
  using Cost = TypeParam;
  const std::vector<Cost> costs = this->rows({{1, 1}, {1, 1}, {1, 1}});
  const std::vector<Cost> before = this->rows({{0, 9}, {9, 0}, {0, 5}});
  const std::vector<Cost> large{7, 7, 7};
  std::vector<Cost> paths(48);
  const auto run = [&](PathsAcross<Cost>* across, int shift) {
    across(std::span<const Cost>(costs), std::span<const Cost>(before), shift, 16, Cost{3},
           std::span<const Cost>(large), std::span<Cost>(paths));
    return paths;
  };
  for (auto* const across : {static_cast<PathsAcross<Cost>*>(ref::paths_across),
                             static_cast<PathsAcross<Cost>*>(neon::paths_across)}) {
    EXPECT_EQ(run(across, 0), this->rows({{1, 4}, {4, 1}, {1, 4}}));
    EXPECT_EQ(run(across, 1), this->rows({{1, 1}, {1, 4}, {4, 1}}));   // column 0 starts
    EXPECT_EQ(run(across, -1), this->rows({{4, 1}, {1, 4}, {1, 1}}));  // the last column starts
  }
}

TYPED_TEST(Path, WhatIsOutsideStaysOutsideAndAnEmptyPixelStartsAnew) {
  using Cost = TypeParam;
  const std::vector<Cost> costs = this->rows({{4, 200}, {}, {6, 2}});
  const std::vector<Cost> large{30, 30, 30};
  std::vector<Cost> paths(48);
  for (auto* const run : {static_cast<PathsAlong<Cost>*>(ref::paths_from_left),
                          static_cast<PathsAlong<Cost>*>(neon::paths_from_left)}) {
    run(std::span<const Cost>(costs), 16, Cost{10}, std::span<const Cost>(large),
        std::span<Cost>(paths));
    EXPECT_EQ(paths, costs);
  }
}

TYPED_TEST(Path, NeonEqualsReferenceAlongRows) {
  using Cost = TypeParam;
  for (int lanes = 16; lanes <= 256; lanes += 16) {
    for (const std::size_t n : {1U, 2U, 3U, 17U}) {
      for (const bool whole_range : {false, true}) {
        test::Random random(n + static_cast<std::size_t>(lanes));
        const std::size_t count = n * static_cast<std::size_t>(lanes);
        test::GuardedBuffer<Cost> costs(count), large(n), other(n), reference(count), neon(count);
        this->fill(costs.span(), random, whole_range);
        random.fill(other.span(), 9, 200);
        random.fill(large.span(), 9, whole_range ? 250 : 60);
        const auto compare = [&](PathsAlong<Cost>* plain, PathsAlong<Cost>* fast) {
          plain(costs.span(), lanes, Cost{9}, large.span(), reference.span());
          fast(costs.span(), lanes, Cost{9}, large.span(), neon.span());
          return std::ranges::equal(reference.span(), neon.span());
        };
        ASSERT_TRUE(compare(ref::paths_from_left, neon::paths_from_left)) << lanes << " x " << n;
        ASSERT_TRUE(compare(ref::paths_from_right, neon::paths_from_right)) << lanes << " x " << n;
        test::GuardedBuffer<Cost> left(count), right(count);
        neon::paths_both_ways(costs.span(), lanes, Cost{9}, other.span(), large.span(), left.span(),
                              right.span());
        ASSERT_TRUE(std::ranges::equal(reference.span(), right.span())) << lanes << " x " << n;
        ref::paths_both_ways(costs.span(), lanes, Cost{9}, other.span(), large.span(), neon.span(),
                             reference.span());
        ASSERT_TRUE(std::ranges::equal(neon.span(), left.span())) << lanes << " x " << n;
        neon::paths_from_right(costs.span(), lanes, Cost{9}, large.span(), costs.span());
        ASSERT_TRUE(std::ranges::equal(reference.span(), costs.span())) << "in place";
      }
    }
  }
}

TYPED_TEST(Path, NeonEqualsReferenceAcrossRows) {
  using Cost = TypeParam;
  for (int lanes = 16; lanes <= 256; lanes += 16) {
    for (const std::size_t n : {1U, 2U, 17U}) {
      for (const int shift : {-1, 0, 1}) {
        test::Random random(n + static_cast<std::size_t>(lanes));
        const std::size_t count = n * static_cast<std::size_t>(lanes);
        test::GuardedBuffer<Cost> costs(count), before(count), large(n), reference(count),
            neon(count);
        this->fill(costs.span(), random, n == 17);
        this->fill(before.span(), random, n == 17);
        random.fill(large.span(), 9, 250);
        ref::paths_across(costs.span(), before.span(), shift, lanes, Cost{9}, large.span(),
                          reference.span());
        neon::paths_across(costs.span(), before.span(), shift, lanes, Cost{9}, large.span(),
                           neon.span());
        ASSERT_TRUE(std::ranges::equal(reference.span(), neon.span())) << lanes << " x " << n;
      }
    }
  }
}

TYPED_TEST(Path, RowWithoutColumnsIsLeftAlone) {
  using Cost = TypeParam;
  neon::paths_from_left(std::span<const Cost>(), 16, Cost{1}, std::span<const Cost>(),
                        std::span<Cost>());
  ref::paths_from_left(std::span<const Cost>(), 16, Cost{1}, std::span<const Cost>(),
                       std::span<Cost>());
  neon::paths_both_ways(std::span<const Cost>(), 16, Cost{1}, std::span<const Cost>(),
                        std::span<const Cost>(), std::span<Cost>(), std::span<Cost>());
  neon::paths_across(std::span<const Cost>(), std::span<const Cost>(), 0, 16, Cost{1},
                     std::span<const Cost>(), std::span<Cost>());
}

}  // namespace
}  // namespace stof::dsp
