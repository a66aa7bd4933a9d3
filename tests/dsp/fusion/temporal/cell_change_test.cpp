#include "dsp/fusion/temporal/cell_change.h"

#include <array>
#include <vector>

#include <gtest/gtest.h>

#include "tests/support/kernel_check.h"

namespace stof::dsp {
namespace {

// One cell: what its pixels were and are, row by row.
bool changes(const std::array<std::uint8_t, 16>& then, const std::array<std::uint8_t, 16>& now) {
  const auto rows = [](const std::array<std::uint8_t, 16>& cell) {
    CellRows out;
    for (std::size_t k = 0; k < out.size(); ++k) {
      out[k] = std::span(cell).subspan(kCellSize * k, kCellSize);
    }
    return out;
  };
  std::array<std::uint8_t, 1> changed{7};
  best::cell_change(rows(now), rows(then), changed);
  EXPECT_TRUE(changed[0] == 0 || changed[0] == 255);
  return changed[0] != 0;
}

TEST(CellChange, IsASumOfMoreThanFourLevelsAPixelOrNineOneByOne) {
  std::array<std::uint8_t, 16> then;
  then.fill(100);
  std::array<std::uint8_t, 16> now;
  now.fill(104);
  EXPECT_FALSE(changes(then, now));
  EXPECT_FALSE(changes(now, then));
  now[5] = 105;
  EXPECT_TRUE(changes(then, now));
  EXPECT_TRUE(changes(now, then));
  for (std::size_t i = 0; i < 16; ++i) {
    now[i] = i % 2 == 0 ? 109 : 91;
  }
  EXPECT_FALSE(changes(then, now));
  now[15] = 90;
  EXPECT_TRUE(changes(then, now));
  then.fill(0);
  now.fill(255);
  EXPECT_TRUE(changes(then, now));
}

TEST(CellChange, EqualsReferenceForEveryLength) {
  int changed_cells = 0;
  int others = 0;
  const bool compared = test::check_kernel([&](test::KernelCase& c) {
    const std::size_t n = c.length();
    CellRows now;
    CellRows then;
    for (std::size_t k = 0; k < now.size(); ++k) {
      const int most = n % 2 == 0 ? 255 : 14;
      now[k] = c.array<std::uint8_t>(kCellSize * n, 0, most);
      then[k] = c.array<std::uint8_t>(kCellSize * n, 0, most);
    }
    const auto changed = c.array<std::uint8_t>(n);
    c.run([&] { best::cell_change(now, then, changed); });
    for (const std::uint8_t each : changed) {
      (each != 0 ? changed_cells : others) += 1;
    }
  });
  if (compared) {
    EXPECT_GT(changed_cells, 100);
    EXPECT_GT(others, 100);
  }
}

}  // namespace
}  // namespace stof::dsp
