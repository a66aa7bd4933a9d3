#include "lab/cost/cost_sums.h"

#include <array>
#include <vector>

#include <gtest/gtest.h>

#include "tests/support/kernel_check.h"

namespace stof::dsp {
namespace {

template <typename Sum>
class CostSums : public testing::Test {};
using Sums = testing::Types<std::uint16_t, std::uint32_t>;
TYPED_TEST_SUITE(CostSums, Sums);

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

}  // namespace
}  // namespace stof::dsp
