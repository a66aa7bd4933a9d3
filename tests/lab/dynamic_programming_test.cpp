#include "lab/search/dynamic_programming.h"

#include <algorithm>
#include <limits>
#include <vector>

#include <gtest/gtest.h>

#include "dsp/stereo/search/winner.h"
#include "lab/search/scanline_optimisation.h"
#include "tests/support/guarded_memory.h"
#include "tests/support/random.h"

namespace stof::lab {
namespace {

constexpr std::uint64_t kImpossible = std::numeric_limits<std::uint64_t>::max();

template <typename Sum>
struct Row {
  std::size_t n;
  int lanes;
  std::vector<Sum> costs;
  std::vector<Sum> large;
  DpPenalties<Sum> penalties;
  std::vector<std::int16_t> winners;

  Row(std::size_t columns, int lane_count)
      : n(columns),
        lanes(lane_count),
        costs(n * static_cast<std::size_t>(lanes), kNoCost<Sum>),
        large(n + 1, Sum{0}),
        winners(n) {
    penalties.large = large;
  }
  Sum& cost(std::size_t x, int i) {
    return costs[x * static_cast<std::size_t>(lanes) + static_cast<std::size_t>(i)];
  }
  void run() {
    test::GuardedBuffer<std::byte> memory(bytes_taken(
        [&](Arena& measuring) { DpTable<Sum>(static_cast<int>(n), lanes, measuring); }));
    Arena arena(memory.span());
    DpTable<Sum> table(static_cast<int>(n), lanes, arena);
    dp_winners(std::span<const Sum>(costs), lanes, penalties, table,
               std::span<std::int16_t>(winners));
  }
  // Of a change from candidate a to b with `skipped` left pixels between, as the header states it.
  std::uint64_t change(int a, int b, int skipped, std::size_t x) const {
    if (skipped > 0) {
      const std::uint64_t occluded = static_cast<std::uint64_t>(skipped) * penalties.occlusion;
      return b != a + skipped ? kImpossible
                              : occluded + (skipped == 1 ? penalties.small : large[x]);
    }
    if (b > a) {
      return kImpossible;
    }
    const std::uint64_t step = b == a - 1 ? penalties.small : large[x];
    return b == a ? 0U : step;
  }
  std::uint64_t energy(std::span<const std::int16_t> row) {
    std::uint64_t sum = 0;
    int last = -1;
    for (std::size_t x = 0; x < n; ++x) {
      if (row[x] == kNoWinner) {
        continue;
      }
      const int skipped = static_cast<int>(x) - last - 1;
      const std::uint64_t before =
          last < 0 ? static_cast<std::uint64_t>(skipped) * penalties.occlusion
                   : change(row[static_cast<std::size_t>(last)], row[x], skipped, x);
      if (before == kImpossible || cost(x, row[x]) == kNoCost<Sum>) {
        return kImpossible;
      }
      sum += before + cost(x, row[x]);
      last = static_cast<int>(x);
    }
    const std::uint64_t after = static_cast<std::uint64_t>(static_cast<int>(n) - 1 - last);
    return last < 0 ? kImpossible : sum + after * penalties.occlusion;
  }
};

template <typename Sum>
bool in_order(const Row<Sum>& row) {
  int right = std::numeric_limits<int>::min();
  for (std::size_t x = 0; x < row.n; ++x) {
    if (row.winners[x] != kNoWinner) {
      const int met = static_cast<int>(x) - row.winners[x];
      if (met <= right) {
        return false;
      }
      right = met;
    }
  }
  return true;
}

template <typename Sum>
class DynamicProgramming : public testing::Test {};
using Sums = testing::Types<std::uint16_t, std::uint32_t>;
TYPED_TEST_SUITE(DynamicProgramming, Sums);

TYPED_TEST(DynamicProgramming, FindsTheLowestEnergyOfAllOrderedRows) {
  for (std::uint64_t seed = 0; seed < 200; ++seed) {
    test::Random random(seed);
    Row<TypeParam> row(1 + seed % 6, 16);
    row.penalties.small = static_cast<TypeParam>(random.between(0, 3));
    row.penalties.occlusion = static_cast<TypeParam>(random.between(0, 6));
    for (TypeParam& large : row.large) {
      large = static_cast<TypeParam>(random.between(static_cast<int>(row.penalties.small), 7));
    }
    for (std::size_t x = 0; x < row.n; ++x) {
      for (int i = 0; i < 4; ++i) {
        if (random.between(0, 5) != 0) {
          row.cost(x, i) = static_cast<TypeParam>(random.between(0, 9));
        }
      }
    }
    if (!any_preference(std::span<const TypeParam>(row.costs), row.lanes)) {
      continue;
    }
    std::vector<std::int16_t> trial(row.n);
    std::uint64_t least = kImpossible;
    const auto descend = [&](const auto& self, std::size_t x) -> void {
      if (x == row.n) {
        least = std::min(least, row.energy(trial));
        return;
      }
      for (std::int16_t i = kNoWinner; i < 4; ++i) {
        trial[x] = i;
        self(self, x + 1);
      }
    };
    descend(descend, 0);
    row.run();
    ASSERT_EQ(row.energy(row.winners), least) << "seed " << seed;
    ASSERT_TRUE(in_order(row)) << "seed " << seed;
  }
}

TYPED_TEST(DynamicProgramming, KeepsTheOrderWhateverTheCosts) {
  for (const std::size_t n : {1U, 2U, 3U, 40U, 100U}) {
    for (const int lanes : {16, 48, 256}) {
      for (const int occlusion : {0, 5, 60}) {
        Row<TypeParam> row(n, lanes);
        test::Random(n).fill(std::span<TypeParam>(row.costs), 0, 40);
        std::ranges::fill(row.large, TypeParam{30});
        row.penalties.small = 4;
        row.penalties.occlusion = static_cast<TypeParam>(occlusion);
        row.run();
        ASSERT_TRUE(in_order(row)) << n << " x " << lanes << " occlusion " << occlusion;
        ASSERT_TRUE(std::ranges::any_of(row.winners, [](int w) { return w != kNoWinner; }));
      }
    }
  }
}

// A bar 6 px nearer than the wall behind it, in columns 10 to 14 of the left image.
template <typename Sum>
Row<Sum> bar_before_wall() {
  Row<Sum> row(24, 16);
  for (std::size_t x = 0; x < row.n; ++x) {
    for (int i = 0; i < 16; ++i) {
      const bool bar = x >= 10 && x <= 14;
      const bool hidden = x >= 4 && x < 10;  // its right column shows the bar
      row.cost(x, i) = !hidden && i == (bar ? 8 : 2) ? Sum{1} : Sum{25};
    }
  }
  std::ranges::fill(row.large, Sum{20});
  row.penalties.small = 6;
  row.penalties.occlusion = 10;
  return row;
}

TYPED_TEST(DynamicProgramming, MarksTheBackgroundThatTheForegroundHidesFromTheRightCamera) {
  Row<TypeParam> row = bar_before_wall<TypeParam>();
  row.run();
  std::vector<std::int16_t> expected(24, 2);
  std::fill_n(expected.begin() + 4, 6, kNoWinner);
  std::fill_n(expected.begin() + 10, 5, std::int16_t{8});
  EXPECT_EQ(row.winners, expected);
}

TYPED_TEST(DynamicProgramming, DenseRowsTakeTheBackground) {
  Row<TypeParam> row = bar_before_wall<TypeParam>();
  row.run();
  row.winners[0] = kNoWinner;
  row.winners[23] = kNoWinner;
  std::vector<std::uint8_t> filled(24, 9);
  extend_background(row.winners, filled);
  std::vector<std::int16_t> expected(24, 2);
  std::fill_n(expected.begin() + 10, 5, std::int16_t{8});
  EXPECT_EQ(row.winners, expected);
  for (std::size_t x = 0; x < 24; ++x) {
    EXPECT_EQ(filled[x], x == 0 || (x >= 4 && x < 10) || x == 23 ? 1 : 0) << x;
  }
}

TYPED_TEST(DynamicProgramming, FlatOrEmptyRowHasNoWinnerAndNothingToExtend) {
  for (const TypeParam cost : {TypeParam{7}, kNoCost<TypeParam>}) {
    Row<TypeParam> row(5, 16);
    std::ranges::fill(row.costs, cost);
    row.run();
    const std::vector<std::int16_t> none(5, kNoWinner);
    EXPECT_EQ(row.winners, none);
    std::vector<std::uint8_t> filled(5, 9);
    extend_background(row.winners, filled);
    EXPECT_EQ(row.winners, none);
    EXPECT_EQ(filled, std::vector<std::uint8_t>(5, 0));
  }
}

TYPED_TEST(DynamicProgramming, SumsBeyondTheTypeEndWithoutAMatchOutsideTheImage) {
  Row<TypeParam> row(30, 16);
  test::Random random(5);
  for (TypeParam& cost : row.costs) {
    cost = random.between(0, 2) == 0
               ? kNoCost<TypeParam>
               : static_cast<TypeParam>(kNoCost<TypeParam> -
                                        static_cast<TypeParam>(random.between(1, 9)));
  }
  std::ranges::fill(row.large, kNoCost<TypeParam>);
  row.penalties.small = kNoCost<TypeParam> / 2;
  row.penalties.occlusion = kNoCost<TypeParam> - 1;
  row.run();
  EXPECT_TRUE(in_order(row));
  for (std::size_t x = 0; x < row.n; ++x) {
    EXPECT_TRUE(row.winners[x] == kNoWinner || row.cost(x, row.winners[x]) != kNoCost<TypeParam>);
  }
}

}  // namespace
}  // namespace stof::lab
