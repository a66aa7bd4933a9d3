#include "lab/cost/cost_sums.h"

#include <algorithm>
#include <array>
#include <vector>

#include <gtest/gtest.h>

#include "dsp/stereo/cost/sad.h"
#include "tests/support/guarded_memory.h"
#include "tests/support/kernel_check.h"
#include "tests/support/random.h"

namespace stof::dsp {
namespace {

template <typename Sum>
class CostSums : public testing::Test {};
using Sums = testing::Types<std::uint16_t, std::uint32_t>;
TYPED_TEST_SUITE(CostSums, Sums);

constexpr std::array<std::size_t, 6> kColumns{1, 2, 15, 16, 17, 33};

struct RowPair {
  test::GuardedBuffer<std::uint8_t> left;
  test::GuardedBuffer<std::uint8_t> right;
  RowPair(std::size_t n, int lanes, std::uint64_t seed, int low = 0, int high = 255)
      : left(n), right(n + static_cast<std::size_t>(lanes) - 1) {
    test::Random random(seed);
    random.fill(left.span(), low, high);
    random.fill(right.span(), low, high);
  }
};

TYPED_TEST(CostSums, SlidingOfDifferencesEqualsAddingTheRowsThatStay) {
  const std::size_t n = 37;
  const int lanes = 48;
  const RowPair first(n, lanes, 1), second(n, lanes, 2), third(n, lanes, 3);
  std::vector<TypeParam> slid(n * 48, 0), added(n * 48, 0);
  best::add_differences(first.left.span(), first.right.span(), lanes, std::span<TypeParam>(slid));
  best::add_differences(second.left.span(), second.right.span(), lanes, std::span<TypeParam>(slid));
  best::slide_differences(third.left.span(), third.right.span(), first.left.span(),
                          first.right.span(), lanes, std::span<TypeParam>(slid));
  best::add_differences(second.left.span(), second.right.span(), lanes,
                        std::span<TypeParam>(added));
  best::add_differences(third.left.span(), third.right.span(), lanes, std::span<TypeParam>(added));
  EXPECT_EQ(slid, added);
}

TYPED_TEST(CostSums, SlidesOfDifferencesEqualReference) {
  for (const int lanes : {16, 32, 48, 64, 80, 128, 256}) {
    test::check_kernel(kColumns, [&](test::KernelCase& c) {
      const std::size_t n = c.length(), right = n + static_cast<std::size_t>(lanes) - 1;
      const auto new_left = c.array<std::uint8_t>(n, 0, 255);
      const auto new_right = c.array<std::uint8_t>(right, 0, 255);
      const auto old_left = c.array<std::uint8_t>(n, 0, 255);
      const auto old_right = c.array<std::uint8_t>(right, 0, 255);
      const auto slid = c.array<TypeParam>(n * static_cast<std::size_t>(lanes), 30000, 30000);
      c.run(
          [&] { best::slide_differences(new_left, new_right, old_left, old_right, lanes, slid); });
    });
  }
}

TYPED_TEST(CostSums, BlockSumsEqualReference) {
  for (const int lanes : {16, 32, 48, 64, 144}) {
    for (const int block : {1, 2, 9, 16, 63, 64}) {
      test::check_kernel(kColumns, [&](test::KernelCase& c) {
        const std::size_t n = c.length() + static_cast<std::size_t>(block) - 1;
        const auto columns = c.array<TypeParam>(n * static_cast<std::size_t>(lanes), 0, 1000);
        const auto costs = c.array<TypeParam>(c.length() * static_cast<std::size_t>(lanes));
        c.run([&] { best::block_sums(columns, block, lanes, costs); });
      });
    }
  }
}

TYPED_TEST(CostSums, SlidingExchangesOneRowForAnother) {
  const std::vector<std::uint8_t> first(16, 200), second(16, 3), third(16, 255);
  std::vector<TypeParam> columns(16, 0);
  const std::span<TypeParam> sums(columns);
  best::add_costs(first, sums);
  best::add_costs(second, sums);
  EXPECT_EQ(columns, std::vector<TypeParam>(16, 203));
  best::slide_costs(third, first, sums);
  EXPECT_EQ(columns, std::vector<TypeParam>(16, 258));
  best::slide_costs(second, third, sums);
  EXPECT_EQ(columns, std::vector<TypeParam>(16, 6));
}

TYPED_TEST(CostSums, EqualReferenceForEveryLength) {
  test::check_kernel(std::array<std::size_t, 6>{0, 1, 2, 3, 5, 20}, [](test::KernelCase& c) {
    const std::size_t n = 16 * c.length();
    const auto entering = c.array<std::uint8_t>(n, 0, 255);
    const auto leaving = c.array<std::uint8_t>(n, 0, 255);
    const auto added = c.array<TypeParam>(n, 300, 300);
    const auto slid = c.array<TypeParam>(n, 300, 300);
    c.run([&] { best::add_costs(entering, added); });
    c.run([&] { best::slide_costs(leaving, entering, slid); });
  });
}

TEST(CostSumsBounds, LargestBlockOfU16ReachesButDoesNotWrap) {
  // 16 x 16 of the largest difference: 65280, below kNoCost.
  const RowPair black(31, 16, 1, 0, 0);
  std::vector<std::uint8_t> white(31, 255);
  std::vector<std::uint16_t> columns(31 * 16, 0), costs(16 * 16, 0);
  for (int row = 0; row < 16; ++row) {
    best::add_differences(white, black.right.span(), 16, std::span<std::uint16_t>(columns));
  }
  best::block_sums(std::span<const std::uint16_t>(columns), 16, 16,
                   std::span<std::uint16_t>(costs));
  EXPECT_TRUE(std::ranges::all_of(costs, [](std::uint16_t c) { return c == 65280; }));
}

}  // namespace
}  // namespace stof::dsp
