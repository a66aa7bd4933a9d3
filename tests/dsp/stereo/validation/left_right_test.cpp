#include "dsp/stereo/validation/left_right.h"

#include <vector>

#include <gtest/gtest.h>

#include "dsp/stereo/search/winner.h"
#include "tests/support/kernel_check.h"

namespace stof::dsp {
namespace {

TEST(LeftRightCheck, KeepsWhatComesBackWithinTheTolerance) {
  // Three columns; column x with winner i looks at right_winners[2 - x + i].
  std::vector<std::int16_t> right{0, 4, 2, 9, kNoWinner, 0};
  std::vector<std::int16_t> winners{1, 1, 4};  // look at 3 (9), 2 (2), 4 (none)
  best::left_right_check(right, 1, winners);
  EXPECT_EQ(winners, (std::vector<std::int16_t>{kNoWinner, 1, kNoWinner}));
  winners = {1, 1, 1};  // look at 3 (9), 2 (2), 1 (4)
  best::left_right_check(right, 0, winners);
  EXPECT_EQ(winners, (std::vector<std::int16_t>{kNoWinner, kNoWinner, kNoWinner}));
}

TEST(LeftRightCheck, EqualsReferenceForEveryLengthAndTolerance) {
  for (const int tolerance : {0, 1, 3, 40000}) {
    test::check_kernel([&](test::KernelCase& c) {
      constexpr int kLanes = 32;
      const auto right = c.array<std::int16_t>(c.length() + kLanes - 1, kNoWinner, 6);
      const auto winners = c.array<std::int16_t>(c.length(), kNoWinner, 6);
      if (!winners.empty()) {
        winners[0] = kLanes - 1;  // reads the last element of the right winners
      }
      c.run([&] { best::left_right_check(right, tolerance, winners); });
    });
  }
}

}  // namespace
}  // namespace stof::dsp
