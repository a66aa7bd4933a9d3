#include "lab/pyramid/pyramid_rows.h"

#include <vector>

#include <gtest/gtest.h>

#include "dsp/stereo/search/winner.h"
#include "tests/support/guarded.h"
#include "tests/support/random.h"

namespace stof::dsp {
namespace {

using Pixels = test::GuardedBuffer<std::uint8_t>;
using Winners = test::GuardedBuffer<std::int16_t>;

// Few values, so that neighbours agree, nearly agree, differ and have none.
void fill(std::span<std::int16_t> winners, test::Random& random) {
  std::vector<std::uint8_t> numbers(winners.size());
  random.fill(std::span<std::uint8_t>(numbers), 0, 4);
  constexpr std::int16_t kSome[] = {kNoWinner, 0, 1, 2, 255};
  for (std::size_t x = 0; x < winners.size(); ++x) {
    winners[x] = kSome[numbers[x]];
  }
}

TEST(PyramidRows, KnownWinnersBetween) {
  const std::vector<std::int16_t> above{7, 7, 8, 7, 9, kNoWinner, 4, kNoWinner};
  const std::vector<std::int16_t> below{7, 8, 7, 9, 7, 4, kNoWinner, kNoWinner};
  const std::vector<std::int16_t> between{7, 7, 8, 7, 7, 4, 4, kNoWinner};
  std::vector<std::int16_t> out(above.size());
  best::between_rows(above, below, out);
  EXPECT_EQ(out, between);
  ref::between_rows(above, below, out);
  EXPECT_EQ(out, between);
}

TEST(PyramidRows, KnownWinnersSpread) {
  const std::vector<std::int16_t> found{5, 6, 60, kNoWinner};
  std::vector<std::int16_t> out(8);
  best::spread_row(found, out);
  EXPECT_EQ(out, (std::vector<std::int16_t>{5, 5, 6, 6, 60, 60, kNoWinner, kNoWinner}));
  out.resize(7);
  best::spread_row(found, out);
  EXPECT_EQ(out, (std::vector<std::int16_t>{5, 5, 6, 6, 60, 60, kNoWinner}));
}

TEST(PyramidRows, EqualTheReferenceForEveryLength) {
  test::Random random(3);
  for (std::size_t n = 1; n <= 100; ++n) {
    Pixels upper(n), lower(n), halves((n + 1) / 2), expected_halves((n + 1) / 2);
    random.fill(upper.span());
    random.fill(lower.span());
    ref::halve_row(upper.span(), lower.span(), expected_halves.span());
    best::halve_row(upper.span(), lower.span(), halves.span());
    for (std::size_t x = 0; x < halves.size(); ++x) {
      ASSERT_EQ(halves[x], expected_halves[x]) << n << " at " << x;
    }
    Winners above(n), below(n), middle(n), expected(n);
    fill(above.span(), random);
    fill(below.span(), random);
    ref::between_rows(above.span(), below.span(), expected.span());
    best::between_rows(above.span(), below.span(), middle.span());
    for (std::size_t x = 0; x < n; ++x) {
      ASSERT_EQ(middle[x], expected[x]) << n << " at " << x;
    }
    Winners found((n + 1) / 2);
    fill(found.span(), random);
    ref::spread_row(found.span(), expected.span());
    best::spread_row(found.span(), middle.span());
    for (std::size_t x = 0; x < n; ++x) {
      ASSERT_EQ(middle[x], expected[x]) << n << " at " << x;
    }
  }
}

}  // namespace
}  // namespace stof::dsp
