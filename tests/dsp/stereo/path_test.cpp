#include "dsp/stereo/search/path.h"

#include <algorithm>
#include <vector>

#include <gtest/gtest.h>

#include "tests/support/guarded.h"
#include "tests/support/random.h"
#include "tests/support/vectors.h"

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

TYPED_TEST(Path, VectorsEqualReferenceAlongRows) {
  using Cost = TypeParam;
  for (const Vectors vectors : test::all_vectors()) {
    const test::UseVectors use(vectors);
    for (int lanes = 16; lanes <= 256; lanes += 16) {
      for (const std::size_t n : {1U, 2U, 3U, 17U}) {
        for (const bool whole_range : {false, true}) {
          test::Random random(n + static_cast<std::size_t>(lanes));
          const std::size_t count = n * static_cast<std::size_t>(lanes);
          test::GuardedBuffer<Cost> costs(count), large(n), other(n), reference(count), neon(count);
          this->fill(costs.span(), random, whole_range);
          random.fill(other.span(), 9, 200);
          random.fill(large.span(), 9, whole_range ? 250 : 60);
          const auto compare = [&](PathsAlong<Cost>* plain, const auto& fast) {
            plain(costs.span(), lanes, Cost{9}, large.span(), reference.span());
            fast(costs.span(), lanes, Cost{9}, large.span(), neon.span());
            return std::ranges::equal(reference.span(), neon.span());
          };
          ASSERT_TRUE(compare(ref::paths_from_left, best::paths_from_left)) << lanes << " x " << n;
          ASSERT_TRUE(compare(ref::paths_from_right, best::paths_from_right))
              << lanes << " x " << n;
          test::GuardedBuffer<Cost> left(count), right(count);
          best::paths_both_ways(costs.span(), lanes, Cost{9}, other.span(), large.span(),
                                left.span(), right.span());
          ASSERT_TRUE(std::ranges::equal(reference.span(), right.span())) << lanes << " x " << n;
          ref::paths_both_ways(costs.span(), lanes, Cost{9}, other.span(), large.span(),
                               neon.span(), reference.span());
          ASSERT_TRUE(std::ranges::equal(neon.span(), left.span())) << lanes << " x " << n;
          best::paths_from_right(costs.span(), lanes, Cost{9}, large.span(), costs.span());
          ASSERT_TRUE(std::ranges::equal(reference.span(), costs.span())) << "in place";
        }
      }
    }
  }
}

TYPED_TEST(Path, VectorsEqualReferenceAcrossRows) {
  using Cost = TypeParam;
  for (const Vectors vectors : test::all_vectors()) {
    const test::UseVectors use(vectors);
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
          best::paths_across(costs.span(), before.span(), shift, lanes, Cost{9}, large.span(),
                             neon.span());
          ASSERT_TRUE(std::ranges::equal(reference.span(), neon.span())) << lanes << " x " << n;
          if (shift == 0) {
            for (const bool plain : {true, false}) {
              std::ranges::copy(before.span(), neon.span().begin());
              if (plain) {
                ref::paths_across(costs.span(), neon.span(), 0, lanes, Cost{9}, large.span(),
                                  neon.span());
              } else {
                best::paths_across(costs.span(), neon.span(), 0, lanes, Cost{9}, large.span(),
                                   neon.span());
              }
              ASSERT_TRUE(std::ranges::equal(reference.span(), neon.span())) << "in place";
            }
          }
        }
      }
    }
  }
}

template <typename Cost>
void expect_axes_equal_reference(int lanes, std::size_t n, bool whole_range,
                                 void (*fill)(std::span<Cost>, test::Random&, bool)) {
  test::Random random(n + static_cast<std::size_t>(lanes));
  const std::size_t count = n * static_cast<std::size_t>(lanes);
  test::GuardedBuffer<Cost> costs(count), large(n), across(n), reference(count), fast(count);
  test::GuardedBuffer<Cost> front(count), other_front(count), others(count);
  fill(costs.span(), random, whole_range);
  fill(others.span(), random, whole_range);
  random.fill(large.span(), 9, 60);
  random.fill(across.span(), 9, 200);
  for (const bool from_left : {false, true}) {
    for (const bool first_row : {false, true}) {
      for (const bool more : {false, true}) {
        fill(front.span(), random, whole_range);
        std::ranges::copy(front.span(), other_front.span().begin());
        const AxesRow<Cost> row{
            .costs = costs.span(),
            .lanes = lanes,
            .small = Cost{9},
            .from_left = from_left,
            .large_along = large.span(),
            .large_across = first_row ? std::span<const Cost>() : across.span()};
        const auto rest = more ? std::span<const Cost>(others.span()) : std::span<const Cost>();
        ref::paths_of_axes(row, front.span(), rest, reference.span());
        std::ranges::copy(others.span(), fast.span().begin());
        best::paths_of_axes(row, other_front.span(),
                            more ? std::span<const Cost>(fast.span()) : rest, fast.span());
        ASSERT_TRUE(std::ranges::equal(front.span(), other_front.span())) << lanes << " x " << n;
        ASSERT_TRUE(std::ranges::equal(reference.span(), fast.span())) << lanes << " x " << n;
      }
    }
  }
}

TYPED_TEST(Path, VectorsEqualReferenceOfBothAxes) {
  using Cost = TypeParam;
  if constexpr (sizeof(Cost) <= 2) {
    for (const Vectors vectors : test::all_vectors()) {
      const test::UseVectors use(vectors);
      for (int lanes = 16; lanes <= 256; lanes += 16) {
        for (const std::size_t n : {1U, 2U, 17U}) {
          expect_axes_equal_reference<Cost>(lanes, n, n == 17, &TestFixture::fill);
        }
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
    ref::paths_from_left(std::span<const Cost>(costs), 32, Cost{5}, std::span<const Cost>(large),
                         std::span(along));
    ref::paths_across(std::span<const Cost>(costs), std::span<const Cost>(front), 0, 32, Cost{5},
                      std::span<const Cost>(across), std::span(down));
    const AxesRow<Cost> row{.costs = costs,
                            .lanes = 32,
                            .small = Cost{5},
                            .from_left = true,
                            .large_along = large,
                            .large_across = across};
    ref::paths_of_axes(row, std::span(front), {}, std::span(sums));
    EXPECT_EQ(front, down);
    for (std::size_t i = 0; i < count; ++i) {
      ASSERT_EQ(sums[i], along[i] + down[i]);
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
