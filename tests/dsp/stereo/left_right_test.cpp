#include "dsp/stereo/check/left_right.h"

#include <algorithm>
#include <vector>

#include <gtest/gtest.h>

#include "dsp/stereo/search/winner.h"
#include "tests/support/guarded.h"
#include "tests/support/random.h"

namespace stof::dsp {
namespace {

TEST(LeftRightCheck, KeepsWhatComesBackWithinTheTolerance) {
  // Three columns; column x with winner i looks at right_winners[2 - x + i].
  std::vector<std::int16_t> right{0, 4, 2, 9, kNoWinner, 0};
  std::vector<std::int16_t> winners{1, 1, 4};  // look at 3 (9), 2 (2), 4 (none)
  ref::left_right_check(right, 1, winners);
  EXPECT_EQ(winners, (std::vector<std::int16_t>{kNoWinner, 1, kNoWinner}));
  winners = {1, 1, 1};  // look at 3 (9), 2 (2), 1 (4)
  ref::left_right_check(right, 0, winners);
  EXPECT_EQ(winners, (std::vector<std::int16_t>{kNoWinner, kNoWinner, kNoWinner}));
}

TEST(LeftRightCheck, NeonEqualsReferenceForEveryLengthAndTolerance) {
  for (std::size_t n = 0; n <= 70; ++n) {
    for (const int tolerance : {0, 1, 3, 40000}) {
      const int lanes = 32;
      test::GuardedBuffer<std::int16_t> right(n + lanes - 1), reference(n), neon(n);
      test::Random random(n);
      random.fill(right.span(), kNoWinner, 6);
      random.fill(reference.span(), kNoWinner, 6);
      if (n > 0) {
        reference[0] = lanes - 1;  // reads the last element of the right winners
      }
      std::ranges::copy(reference.span(), neon.span().begin());
      ref::left_right_check(right.span(), tolerance, reference.span());
      neon::left_right_check(right.span(), tolerance, neon.span());
      ASSERT_TRUE(std::ranges::equal(reference.span(), neon.span())) << n << ", " << tolerance;
    }
  }
}

}  // namespace
}  // namespace stof::dsp
