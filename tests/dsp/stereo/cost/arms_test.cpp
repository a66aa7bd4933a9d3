#include "dsp/stereo/cost/arms.h"

#include <array>
#include <vector>

#include <gtest/gtest.h>

#include "tests/support/kernel_check.h"

namespace stof::dsp {
namespace {

using Row = std::vector<std::uint8_t>;

TEST(Arms, ReachAsFarAsPixelsLookLikeTheirCentre) {
  const Row row{10, 10, 14, 30, 30, 30, 29, 90};
  Row left(row.size());
  Row right(row.size());
  best::arms_along(row, {.longest = 3, .difference = 4}, left, right);
  EXPECT_EQ(left, (Row{0, 1, 2, 1, 1, 2, 3, 1}));
  EXPECT_EQ(right, (Row{2, 1, 1, 3, 2, 1, 1, 0}));
}

TEST(Arms, AcrossRowsEndWithTheImage) {
  const Row here{10, 50, 90};
  const Row above{12, 80, 91};
  const Row higher{11, 50, 10};
  Row arms(3);
  const std::array<const std::uint8_t*, 2> others{above.data(), higher.data()};
  best::arms_across(here, others, {.longest = 5, .difference = 4}, arms);
  EXPECT_EQ(arms, (Row{2, 1, 1}));
  best::arms_across(here, {}, {.longest = 5, .difference = 4}, arms);
  EXPECT_EQ(arms, (Row{0, 0, 0}));
}

TEST(Arms, EqualReferenceForEveryLength) {
  for (const ArmParams params : {ArmParams{1, 0}, ArmParams{5, 20}, ArmParams{12, 60},
                                 ArmParams{kMaxArm, 200}, ArmParams{kMaxArm, 255}}) {
    test::check_kernel([&](test::KernelCase& c) {
      const std::size_t n = c.length();
      const auto row = c.array<std::uint8_t>(n, 0, 255);
      const auto left = c.array<std::uint8_t>(n);
      const auto right = c.array<std::uint8_t>(n);
      c.run([&] { best::arms_along(row, params, left, right); });
      const auto arms = c.array<std::uint8_t>(n);
      std::vector<const std::uint8_t*> others;
      for (int k = 0; k < params.longest - static_cast<int>(n % 3) % params.longest; ++k) {
        others.push_back(c.array<std::uint8_t>(n, 0, 255).data());
      }
      c.run([&] { best::arms_across(row, others, params, arms); });
    });
  }
}

}  // namespace
}  // namespace stof::dsp
