#include "dsp/stereo/search/sum_path_costs.h"

#include <algorithm>
#include <array>
#include <limits>
#include <vector>

#include <gtest/gtest.h>

#include "tests/support/kernel_check.h"

namespace stof::dsp {
namespace {

template <typename Cost, typename Sum>
void expect_equal_sums() {
  for (std::size_t count = 2; count <= 8; ++count) {
    test::check_kernel(std::array<std::size_t, 5>{0, 16, 32, 48, 160}, [&](test::KernelCase& c) {
      std::vector<const Cost*> rows;
      for (std::size_t k = 0; k < count; ++k) {
        rows.push_back(c.array<Cost>(c.length(), 0, sizeof(Cost) == 1 ? 255 : 8191).data());
      }
      const auto sums = c.array<Sum>(c.length());
      c.run([&] { best::sum_path_costs(std::span<const Cost* const>(rows), sums); });
      for (std::size_t i = 0; i < c.length(); ++i) {
        std::size_t total = 0;
        for (const Cost* const row : rows) {
          total += row[i];
        }
        ASSERT_EQ(sums[i], std::min<std::size_t>(total, std::numeric_limits<Sum>::max()));
      }
    });
  }
}

TEST(SumPathCosts, EqualReferenceForEveryNumberOfDirections) {
  expect_equal_sums<std::uint8_t, std::uint8_t>();
  expect_equal_sums<std::uint8_t, std::uint16_t>();
  expect_equal_sums<std::uint16_t, std::uint16_t>();
}

}  // namespace
}  // namespace stof::dsp
