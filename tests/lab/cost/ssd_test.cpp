#include "lab/cost/ssd.h"

#include <array>
#include <vector>

#include <gtest/gtest.h>

#include "tests/support/guarded_memory.h"
#include "tests/support/kernel_check.h"
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
class Ssd : public testing::Test {};
using Sums = testing::Types<std::uint16_t, std::uint32_t>;
TYPED_TEST_SUITE(Ssd, Sums);

TYPED_TEST(Ssd, IsTheSquareOfTheDifferenceFromTheReversedRightRow) {
  const std::vector<std::uint8_t> left{0, 50};
  std::vector<std::uint8_t> right(17);
  for (std::size_t m = 0; m < right.size(); ++m) {
    right[m] = static_cast<std::uint8_t>(10 * m);
  }
  right[16] = 255;
  std::vector<TypeParam> columns(32, 1);
  best::add_squares(left, right, 16, std::span<TypeParam>(columns));
  EXPECT_EQ(columns[0], 1 + 100);          // (0 - right[1])^2
  EXPECT_EQ(columns[15], 1 + 65025);       // (0 - right[16])^2
  EXPECT_EQ(columns[16], 1 + 2500);        // (50 - right[0])^2
  EXPECT_EQ(columns[16 + 7], 1 + 400);     // (50 - right[7])^2
  EXPECT_EQ(columns[16 + 15], 1 + 10000);  // (50 - right[15])^2
}

TYPED_TEST(Ssd, SlidingEqualsAddingTheRowsThatStay) {
  const Row left_a = random_row(9, 1), right_a = random_row(9 + 31, 2);
  const Row left_b = random_row(9, 3), right_b = random_row(9 + 31, 4);
  std::vector<TypeParam> slid(9 * 32, 0), added(9 * 32, 0);
  best::add_squares(left_a.span(), right_a.span(), 32, std::span<TypeParam>(slid));
  best::slide_squares(left_b.span(), right_b.span(), left_a.span(), right_a.span(), 32,
                      std::span<TypeParam>(slid));
  best::add_squares(left_b.span(), right_b.span(), 32, std::span<TypeParam>(added));
  EXPECT_EQ(slid, added);
}

TYPED_TEST(Ssd, EqualsReferenceForEveryShape) {
  for (const int lanes : {16, 48, 64, 80, 256}) {
    test::check_kernel(std::array<std::size_t, 5>{1, 2, 15, 16, 17}, [&](test::KernelCase& c) {
      const std::size_t n = c.length(), right = n + static_cast<std::size_t>(lanes) - 1;
      const auto new_left = c.array<std::uint8_t>(n, 0, 255);
      const auto new_right = c.array<std::uint8_t>(right, 0, 255);
      const auto old_left = c.array<std::uint8_t>(n, 0, 255);
      const auto old_right = c.array<std::uint8_t>(right, 0, 255);
      const auto added = c.array<TypeParam>(n * static_cast<std::size_t>(lanes), 300, 300);
      const auto slid = c.array<TypeParam>(n * static_cast<std::size_t>(lanes), 300, 300);
      c.run([&] { best::add_squares(new_left, new_right, lanes, added); });
      c.run([&] { best::slide_squares(new_left, new_right, old_left, old_right, lanes, slid); });
    });
  }
}

TEST(SsdBounds, TheLargestBlockFitsTheWideSum) {
  const std::vector<std::uint8_t> white{255}, black(16, 0);
  std::vector<std::uint32_t> columns(16, 64 * 64 * 65025U - 65025U);
  best::add_squares(white, black, 16, std::span<std::uint32_t>(columns));
  EXPECT_EQ(columns, std::vector<std::uint32_t>(16, 266'342'400U));
}

}  // namespace
}  // namespace stof::dsp
