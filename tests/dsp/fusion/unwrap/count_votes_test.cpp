#include "dsp/fusion/unwrap/count_votes.h"

#include <gtest/gtest.h>

#include "dsp/fusion/project/project.h"
#include "tests/support/guarded_memory.h"
#include "tests/support/kernel_check.h"

namespace stof::dsp {
namespace {

// A grid whose last sample, border included, ends at an unreadable page.
class Grid {
 public:
  Grid(int columns, int rows, int step_bits)
      : low_(columns + 2 * kGridBorder, rows + 2 * kGridBorder, columns + 2 * kGridBorder,
             kMaxQuarterMm),
        high_(columns + 2 * kGridBorder, rows + 2 * kGridBorder, columns + 2 * kGridBorder,
              kNoDepth),
        columns_(columns),
        rows_(rows),
        step_bits_(step_bits) {}
  void put(int i, int j, int low, int high) {
    low_.view().at(i + kGridBorder, j + kGridBorder) = static_cast<QuarterMm>(low);
    high_.view().at(i + kGridBorder, j + kGridBorder) = static_cast<QuarterMm>(high);
  }
  SampleGrid grid() {
    return {.low = &low_.view().at(kGridBorder, kGridBorder),
            .high = &high_.view().at(kGridBorder, kGridBorder),
            .stride = low_.view().stride(),
            .columns = columns_,
            .rows = rows_,
            .step_bits = step_bits_};
  }

 private:
  test::GuardedImage<QuarterMm> low_, high_;
  int columns_;
  int rows_;
  int step_bits_;
};

struct At {
  int x;  // px
  int y;
  int depth;
  int tolerance = 100;
};
Votes votes(Grid& grid, At at, int far_off = 4000) {
  const std::int32_t u = at.x * kPositionOne;
  const std::int32_t v = at.y * kPositionOne;
  const auto depth = static_cast<QuarterMm>(at.depth);
  const auto tolerance = static_cast<QuarterMm>(at.tolerance);
  Votes out{0xFFFF};
  best::count_votes({{&u, 1}, {&v, 1}, {&depth, 1}, {&tolerance, 1}}, grid.grid(),
                    static_cast<QuarterMm>(far_off), {&out, 1});
  return out;
}

TEST(CountVotes, TellsWhatAgreesFromWhatLiesFarOff) {
  Grid grid(4, 4, 2);
  grid.put(0, 0, 7900, 8100);    // holds the reading
  grid.put(1, 0, 8101, 9000);    // one beyond the tolerance
  grid.put(2, 0, 8100, 9000);    // touches it
  grid.put(3, 3, 12001, 13000);  // far behind
  grid.put(2, 3, 3000, 3999);    // far before
  grid.put(1, 3, 3000, 4000);    // not quite
  const Votes found = votes(grid, {.x = 8, .y = 8, .depth = 8000});
  EXPECT_EQ(found.known(), 6);
  EXPECT_EQ(found.agree(), 2);
  EXPECT_EQ(found.apart(), 2);
}

TEST(CountVotes, LooksAtTheFourByFourSamplesAroundThePlace) {
  for (const int step_bits : {1, 2, 4}) {
    const int step = 1 << step_bits;
    Grid grid(9, 9, step_bits);
    grid.put(4, 4, 8000, 8000);
    int columns = 0;
    for (int x = 0; x < 9 * step; ++x) {
      const int known = votes(grid, {.x = x, .y = 4 * step, .depth = 8000}).known();
      columns += known;
      // The sample's own pixel is in the middle of the window.
      EXPECT_TRUE(known == 1 || x != 4 * step + step / 2);
    }
    EXPECT_EQ(columns, kWindow * step);
  }
}

TEST(CountVotes, FindsNothingWithoutDepthAndFarOutside) {
  Grid grid(3, 3, 1);
  for (int i = 0; i < 9; ++i) {
    grid.put(i % 3, i / 3, 1, kMaxQuarterMm);
  }
  EXPECT_EQ(votes(grid, {.x = 3, .y = 3, .depth = 0}), Votes{});
  EXPECT_EQ(votes(grid, {.x = 65536, .y = 3, .depth = 8000}), Votes{});
  EXPECT_EQ(votes(grid, {.x = 3, .y = -65536, .depth = 8000}), Votes{});
  EXPECT_EQ(votes(grid, {.x = 3, .y = 3, .depth = 8000}).agree(), 9);
}

TEST(CountVotes, SaturatesAtBothEnds) {
  Grid grid(4, 4, 1);
  grid.put(0, 0, kMaxQuarterMm, kMaxQuarterMm);
  EXPECT_EQ(votes(grid, {.x = 4, .y = 4, .depth = 65000, .tolerance = 60000}).agree(), 1);
  EXPECT_EQ(votes(grid, {.x = 4, .y = 4, .depth = 500}).apart(), 1);
  EXPECT_EQ(votes(grid, {.x = 4, .y = 4, .depth = 65000}, 65535).apart(), 0);
}

TEST(CountVotes, EqualReferenceForEveryLength) {
  for (const int step_bits : {1, 2, 4}) {
    test::check_kernel([&](test::KernelCase& c) {
      const std::size_t n = c.length();
      const int columns = c.random().between(1, 12), rows = c.random().between(1, 9);
      Grid grid(columns, rows, step_bits);
      for (int k = columns * rows; k-- > 0;) {
        if (c.random().between(0, 3) != 0) {
          const int low = c.draw(1, kMaxQuarterMm);
          grid.put(k % columns, k / columns, low, c.draw(low, kMaxQuarterMm));
        }
      }
      const int size = kPositionOne << step_bits;
      const auto u = c.array<std::int32_t>(n, -3 * size, (columns + 3) * size);
      const auto v = c.array<std::int32_t>(n, -3 * size, (rows + 3) * size);
      const auto depth = c.array<QuarterMm>(n, 0, kMaxQuarterMm);
      const auto tolerance = c.array<QuarterMm>(n, 0, n % 2 == 0 ? 20000 : kMaxQuarterMm);
      for (std::size_t i = 0; i < n; ++i) {
        const bool empty = n % 3 == 0 && i < 16;  // whole vectors without a reading
        depth[i] = empty || c.random().between(0, 5) == 0 ? kNoDepth : depth[i];
      }
      const auto far_off = static_cast<QuarterMm>(c.draw(0, 20000));
      const auto votes = c.array<Votes>(n);
      c.run([&] { best::count_votes({u, v, depth, tolerance}, grid.grid(), far_off, votes); });
    });
  }
}

}  // namespace
}  // namespace stof::dsp
