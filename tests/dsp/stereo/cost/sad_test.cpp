#include "dsp/stereo/cost/sad.h"

#include <array>
#include <vector>

#include <gtest/gtest.h>

#include "tests/support/kernel_check.h"

namespace stof::dsp {
namespace {

template <typename Sum>
class Sad : public testing::Test {};
using Sums = testing::Types<std::uint16_t, std::uint32_t>;
TYPED_TEST_SUITE(Sad, Sums);

TYPED_TEST(Sad, CandidateOfAColumnIsTheReversedRightRow) {
  // n = 2 columns, 16 lanes: column 1 meets candidate i at right[i], column 0 at right[1 + i].
  std::vector<std::uint8_t> left{100, 50};
  std::vector<std::uint8_t> right(17);
  for (std::size_t m = 0; m < right.size(); ++m) {
    right[m] = static_cast<std::uint8_t>(10 * m);
  }
  std::vector<TypeParam> columns(32, 1);
  best::add_differences(left, right, 16, std::span<TypeParam>(columns));
  EXPECT_EQ(columns[0], 1 + 90);         // |100 - right[1]|
  EXPECT_EQ(columns[9], 1 + 0);          // |100 - right[10]|
  EXPECT_EQ(columns[16], 1 + 50);        // |50 - right[0]|
  EXPECT_EQ(columns[16 + 15], 1 + 100);  // |50 - right[15]|
}

TYPED_TEST(Sad, AddsEqualReference) {
  for (const int lanes : {16, 32, 48, 64, 80, 128, 256}) {
    test::check_kernel(std::array<std::size_t, 6>{1, 2, 15, 16, 17, 33}, [&](test::KernelCase& c) {
      const std::size_t n = c.length();
      const auto left = c.array<std::uint8_t>(n, 0, 255);
      const auto right = c.array<std::uint8_t>(n + static_cast<std::size_t>(lanes) - 1, 0, 255);
      const auto added = c.array<TypeParam>(n * static_cast<std::size_t>(lanes), 30000, 30000);
      c.run([&] { best::add_differences(left, right, lanes, added); });
    });
  }
}

}  // namespace
}  // namespace stof::dsp
