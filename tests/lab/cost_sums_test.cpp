#include "lab/cost/cost_sums.h"

#include <algorithm>
#include <vector>

#include <gtest/gtest.h>

#include "tests/support/guarded.h"
#include "tests/support/random.h"

namespace stof::dsp {
namespace {

using Row = test::GuardedBuffer<std::uint8_t>;

Row random_row(std::size_t n, std::uint64_t seed) {
  Row row(n);
  test::Random(seed).fill(row.span());
  return row;
}

template <typename Sum>
class CostSums : public testing::Test {};
using Sums = testing::Types<std::uint16_t, std::uint32_t>;
TYPED_TEST_SUITE(CostSums, Sums);

TYPED_TEST(CostSums, SlidingExchangesOneRowForAnother) {
  const std::vector<std::uint8_t> first(16, 200), second(16, 3), third(16, 255);
  std::vector<TypeParam> columns(16, 0);
  const std::span<TypeParam> sums(columns);
  ref::add_costs(first, sums);
  ref::add_costs(second, sums);
  EXPECT_EQ(columns, std::vector<TypeParam>(16, 203));
  ref::slide_costs(third, first, sums);
  EXPECT_EQ(columns, std::vector<TypeParam>(16, 258));
  ref::slide_costs(second, third, sums);
  EXPECT_EQ(columns, std::vector<TypeParam>(16, 6));
}

TYPED_TEST(CostSums, NeonEqualsReferenceForEveryLength) {
  for (std::size_t n = 0; n <= 20 * 16; n += 16) {
    const Row entering = random_row(n, n), leaving = random_row(n, n + 1);
    test::GuardedBuffer<TypeParam> reference(n, 300), neon(n, 300);
    ref::add_costs(entering.span(), reference.span());
    neon::add_costs(entering.span(), neon.span());
    ASSERT_TRUE(std::ranges::equal(reference.span(), neon.span())) << "length " << n;
    ref::slide_costs(leaving.span(), entering.span(), reference.span());
    neon::slide_costs(leaving.span(), entering.span(), neon.span());
    ASSERT_TRUE(std::ranges::equal(reference.span(), neon.span())) << "length " << n;
  }
}

}  // namespace
}  // namespace stof::dsp
