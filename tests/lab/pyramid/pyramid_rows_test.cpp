#include "lab/pyramid/pyramid_rows.h"

#include <array>
#include <vector>

#include <gtest/gtest.h>

#include "dsp/stereo/search/winner.h"
#include "tests/support/kernel_check.h"

namespace stof::dsp {
namespace {

// Few values, so that neighbours agree, nearly agree, differ and have none.
std::span<std::int16_t> winners(test::KernelCase& c, std::size_t n) {
  constexpr std::array<std::int16_t, 5> kSome{kNoWinner, 0, 1, 2, 255};
  const auto out = c.array<std::int16_t>(n);
  for (std::int16_t& winner : out) {
    winner = kSome[static_cast<std::size_t>(c.draw(0, 4))];
  }
  return out;
}

TEST(PyramidRows, KnownWinnersBetween) {
  const std::vector<std::int16_t> above{7, 7, 8, 7, 9, kNoWinner, 4, kNoWinner};
  const std::vector<std::int16_t> below{7, 8, 7, 9, 7, 4, kNoWinner, kNoWinner};
  const std::vector<std::int16_t> between{7, 7, 8, 7, 7, 4, 4, kNoWinner};
  std::vector<std::int16_t> out(above.size());
  best::between_rows(above, below, out);
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

TEST(PyramidRows, EqualReferenceForEveryLength) {
  test::check_kernel(std::span(test::kHostileLengths).subspan(1), [](test::KernelCase& c) {
    const std::size_t n = c.length();
    const auto upper = c.array<std::uint8_t>(n, 0, 255), lower = c.array<std::uint8_t>(n, 0, 255);
    const auto halves = c.array<std::uint8_t>((n + 1) / 2);
    c.run([&] { best::halve_row(upper, lower, halves); });
    const auto above = winners(c, n), below = winners(c, n);
    const auto between = c.array<std::int16_t>(n);
    c.run([&] { best::between_rows(above, below, between); });
    const auto found = winners(c, (n + 1) / 2);
    const auto spread = c.array<std::int16_t>(n);
    c.run([&] { best::spread_row(found, spread); });
  });
}

}  // namespace
}  // namespace stof::dsp
