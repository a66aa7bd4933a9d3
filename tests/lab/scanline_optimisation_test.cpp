#include "lab/search/scanline_optimisation.h"

#include <algorithm>
#include <cstdlib>
#include <limits>
#include <vector>

#include <gtest/gtest.h>

#include "dsp/stereo/search/winner.h"
#include "tests/support/guarded_memory.h"
#include "tests/support/random.h"

namespace stof::lab {
namespace {

constexpr int kLanes = 16;
constexpr std::uint64_t kImpossible = std::numeric_limits<std::uint64_t>::max();

template <typename Sum>
struct Row {
  std::size_t n;
  int candidates;  // the other lanes are empty
  Sum small;
  std::vector<Sum> costs;
  std::vector<Sum> large;
  std::vector<Sum> paths;
  std::vector<std::int16_t> winners;

  Row(std::size_t columns, int offered, std::uint64_t seed)
      : n(columns),
        candidates(offered),
        costs(n * kLanes, kNoCost<Sum>),
        large(n + 1),
        paths(n * kLanes),
        winners(n) {
    test::Random random(seed);
    small = static_cast<Sum>(random.between(0, 4));
    for (std::size_t x = 0; x < n; ++x) {
      for (int i = 0; i < candidates; ++i) {
        if (random.between(0, 5) != 0) {
          costs[x * kLanes + static_cast<std::size_t>(i)] = static_cast<Sum>(random.between(0, 6));
        }
      }
      large[x] = static_cast<Sum>(random.between(static_cast<int>(small), 9));
    }
  }
  void run() {
    scanline_winners(std::span<const Sum>(costs), kLanes, small, std::span<const Sum>(large),
                     std::span<Sum>(paths), std::span<std::int16_t>(winners));
  }
  // As the header states it; a pixel without a candidate ends one part and begins the next.
  std::uint64_t energy(std::span<const std::int16_t> row) const {
    std::uint64_t sum = 0;
    for (std::size_t x = 0; x < n; ++x) {
      if (row[x] == kNoWinner) {
        continue;
      }
      const Sum cost = costs[x * kLanes + static_cast<std::size_t>(row[x])];
      if (cost == kNoCost<Sum>) {
        return kImpossible;
      }
      sum += cost;
      if (x > 0 && row[x - 1] != kNoWinner) {
        const int change = std::abs(row[x] - row[x - 1]);
        const std::uint64_t step = change == 1 ? std::min(small, large[x]) : large[x];
        sum += change == 0 ? 0U : step;
      }
    }
    return sum;
  }
  bool empty(std::size_t x) const {
    return std::all_of(costs.begin() + static_cast<std::ptrdiff_t>(x * kLanes),
                       costs.begin() + static_cast<std::ptrdiff_t>((x + 1) * kLanes),
                       [](Sum cost) { return cost == kNoCost<Sum>; });
  }
};

// Every row of candidates, in the order of the tie rule: the last pixel counts most.
template <typename Sum, typename Visit>
void for_each_row(const Row<Sum>& row, Visit visit) {
  std::vector<std::int16_t> trial(row.n);
  const auto descend = [&](const auto& self, std::size_t left) -> void {
    if (left == 0) {
      visit(std::span<const std::int16_t>(trial));
      return;
    }
    const bool empty = row.empty(left - 1);
    for (int i = 0; i < (empty ? 1 : row.candidates); ++i) {
      trial[left - 1] = empty ? kNoWinner : static_cast<std::int16_t>(i);
      self(self, left - 1);
    }
  };
  descend(descend, row.n);
}

template <typename Sum>
class ScanlineOptimisation : public testing::Test {};
using Sums = testing::Types<std::uint16_t, std::uint32_t>;
TYPED_TEST_SUITE(ScanlineOptimisation, Sums);

TYPED_TEST(ScanlineOptimisation, FindsTheRowOfLowestEnergyAndTheSmallestOfTies) {
  for (std::uint64_t seed = 0; seed < 300; ++seed) {
    Row<TypeParam> row(1 + seed % 6, 4, seed);
    if (!any_preference(std::span<const TypeParam>(row.costs), kLanes)) {
      continue;
    }
    row.run();
    std::uint64_t least = kImpossible;
    std::vector<std::int16_t> best;
    for_each_row(row, [&](std::span<const std::int16_t> trial) {
      const std::uint64_t energy = row.energy(trial);
      if (energy < least) {
        least = energy;
        best.assign(trial.begin(), trial.end());
      }
    });
    ASSERT_EQ(row.energy(row.winners), least) << "seed " << seed;
    ASSERT_EQ(row.winners, best) << "seed " << seed;
  }
}

TYPED_TEST(ScanlineOptimisation, MarginalsAreTheLowestEnergiesThroughEachCandidate) {
  for (std::uint64_t seed = 0; seed < 100; ++seed) {
    Row<TypeParam> row(2 + seed % 4, 4, seed);
    row.run();
    std::vector<TypeParam> marginals(row.costs.size());
    scanline_marginals(std::span<const TypeParam>(row.costs), kLanes, row.small,
                       std::span<const TypeParam>(row.large), std::span<const TypeParam>(row.paths),
                       std::span<TypeParam>(marginals));
    std::vector<std::uint64_t> through(row.costs.size(), kImpossible);
    std::uint64_t least = kImpossible;
    for_each_row(row, [&](std::span<const std::int16_t> trial) {
      const std::uint64_t energy = row.energy(trial);
      least = std::min(least, energy);
      for (std::size_t x = 0; x < row.n; ++x) {
        if (trial[x] != kNoWinner) {
          std::uint64_t& at = through[x * kLanes + static_cast<std::size_t>(trial[x])];
          at = std::min(at, energy);
        }
      }
    });
    for (std::size_t x = 0; x < row.n; ++x) {
      const std::span<const TypeParam> pixel =
          std::span<const TypeParam>(marginals).subspan(x * kLanes, kLanes);
      const TypeParam lowest = *std::ranges::min_element(pixel);
      for (std::size_t i = 0; i < kLanes; ++i) {
        const std::uint64_t expected = through[x * kLanes + i];
        if (expected == kImpossible) {
          ASSERT_EQ(pixel[i], kNoCost<TypeParam>) << "seed " << seed;
        } else {
          ASSERT_EQ(pixel[i] - lowest, expected - least) << "seed " << seed;
        }
      }
    }
  }
}

TYPED_TEST(ScanlineOptimisation, FlatRowAndPixelsWithoutCandidatesHaveNoWinner) {
  Row<TypeParam> row(4, 4, 1);
  std::ranges::fill(row.costs, TypeParam{7});
  row.run();
  EXPECT_EQ(row.winners, (std::vector<std::int16_t>{-1, -1, -1, -1}));
  std::fill_n(row.costs.begin() + kLanes, kLanes, kNoCost<TypeParam>);
  row.costs[2] = 3;
  row.run();
  EXPECT_EQ(row.winners, (std::vector<std::int16_t>{2, -1, 0, 0}));
}

TYPED_TEST(ScanlineOptimisation, OnePixelAndManyStayInsideTheirMemory) {
  for (const std::size_t n : {1U, 2U, 33U}) {
    for (const int lanes : {16, 64, 256}) {
      const std::size_t count = n * static_cast<std::size_t>(lanes);
      test::GuardedBuffer<TypeParam> costs(count), paths(count), marginals(count);
      test::GuardedBuffer<TypeParam> large(n + 1, TypeParam{30});
      test::GuardedBuffer<std::int16_t> winners(n), near(n);
      test::Random(n).fill(costs.span(), 0, 100);
      const std::span<const TypeParam> row = costs.span();
      scanline_winners(row, lanes, TypeParam{9}, std::span<const TypeParam>(large.span()),
                       paths.span(), winners.span());
      scanline_marginals(row, lanes, TypeParam{9}, std::span<const TypeParam>(large.span()),
                         std::span<const TypeParam>(paths.span()), marginals.span());
      best::winners(std::span<const TypeParam>(marginals.span()), lanes, near.span());
      for (std::size_t x = 0; x < n; ++x) {  // both minimise; ties may be told apart differently
        const std::size_t at = x * static_cast<std::size_t>(lanes);
        ASSERT_GE(winners[x], 0);
        ASSERT_EQ(marginals[at + static_cast<std::size_t>(winners[x])],
                  marginals[at + static_cast<std::size_t>(near[x])]);
      }
    }
  }
}

TYPED_TEST(ScanlineOptimisation, BandKeepsWhatLiesNearWinnersOfTheNeighbourhood) {
  const std::size_t n = 2 * kBandReach + 2;
  std::vector<TypeParam> costs(n * kLanes, 5);
  std::vector<std::int16_t> winners(n, 6);
  winners[0] = 9;          // seen up to column kBandReach
  winners[5] = kNoWinner;  // says nothing
  keep_band(std::span<const std::int16_t>(winners), kLanes, 1, std::span<TypeParam>(costs));
  const auto kept = [&](std::size_t x) {
    std::vector<int> out;
    for (int i = 0; i < kLanes; ++i) {
      if (costs[x * kLanes + static_cast<std::size_t>(i)] == 5) {
        out.push_back(i);
      }
    }
    return out;
  };
  EXPECT_EQ(kept(0), (std::vector<int>{5, 6, 7, 8, 9, 10}));
  EXPECT_EQ(kept(kBandReach), (std::vector<int>{5, 6, 7, 8, 9, 10}));
  EXPECT_EQ(kept(kBandReach + 1), (std::vector<int>{5, 6, 7}));
}

TYPED_TEST(ScanlineOptimisation, BandNeverEmptiesAPixel) {
  for (std::uint64_t seed = 0; seed < 50; ++seed) {
    Row<TypeParam> row(40, 12, seed);
    std::vector<std::int16_t> winners(row.n, kNoWinner);
    if (seed > 0) {
      best::winners(std::span<const TypeParam>(row.costs), kLanes, winners);
      winners[3] = 15;  // a candidate that nobody offers
    }
    std::vector<bool> empty(row.n);
    for (std::size_t x = 0; x < row.n; ++x) {
      empty[x] = row.empty(x);
    }
    keep_band(std::span<const std::int16_t>(winners), kLanes, static_cast<int>(seed % 3),
              std::span<TypeParam>(row.costs));
    for (std::size_t x = 0; x < row.n; ++x) {
      ASSERT_EQ(row.empty(x), empty[x]) << "seed " << seed;
    }
  }
}

}  // namespace
}  // namespace stof::lab
