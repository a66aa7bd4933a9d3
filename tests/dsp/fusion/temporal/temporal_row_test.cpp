#include "dsp/fusion/temporal/temporal_row.h"

#include <algorithm>
#include <array>
#include <vector>

#include <gtest/gtest.h>

#include "tests/support/guarded_memory.h"
#include "tests/support/kernel_check.h"

namespace stof::dsp {
namespace {

using Bytes = test::GuardedBuffer<std::uint8_t>;
using Words = test::GuardedBuffer<std::uint16_t>;

// A row and what is remembered of it, in memory that ends at an unreadable page.
struct Row {
  explicit Row(std::size_t n)
      : changed(n), source(n), depth(n), width(n), mean(n), scatter(n), tally(n), kind(n) {}

  TemporalRow row() {
    return {.changed = changed.span(),
            .source = source.span(),
            .depth = depth.span(),
            .width = width.span()};
  }
  TemporalState state() {
    return {
        .mean = mean.span(), .scatter = scatter.span(), .tally = tally.span(), .kind = kind.span()};
  }
  Bytes changed;
  test::GuardedBuffer<Source> source;
  Words depth, width, mean, scatter;
  Bytes tally, kind;
};

enum class Scene { kAnything, kStill, kCreeping };

TemporalRow next_frame(Scene scene, int frame, test::KernelCase& c) {
  const std::size_t n = c.length();
  const auto changed = c.array<std::uint8_t>(n, 0, scene == Scene::kAnything ? 1 : 0);
  const TemporalRow row{.changed = changed,
                        .source = c.array<Source>(n, scene == Scene::kAnything ? 0 : 3,
                                                  scene == Scene::kAnything ? 255 : 3),
                        .depth = c.array<QuarterMm>(n),
                        .width = c.array<QuarterMm>(n)};
  static_assert(static_cast<int>(Source::kBoth) == 3);
  for (std::size_t x = 0; x < n && scene != Scene::kAnything; ++x) {
    const int at = static_cast<int>(x);
    // Also where a mean or an interval would leave u16.
    const int base = at % 5 == 0 ? 65535 - 60 * at : 60 + 700 * at % 50000;
    const int creep = scene == Scene::kCreeping ? frame * at % 90 : 0;
    const int width = at % 7 == 0 ? 65535 : 40 * at;
    row.width[x] = static_cast<QuarterMm>(width);
    const int noise = c.random().between(-width / 4, width / 4);
    row.depth[x] = static_cast<QuarterMm>(std::clamp(base + creep + noise, 1, 65535));
    if (c.random().between(0, 40) == 0) {
      row.depth[x] = kNoDepth;
    }
  }
  return row;
}

// Worked by hand: width 800, so half 400; a mean of depths 8000, 8100, 7900, 8060.
TEST(TemporalRow, FollowsTheFormula) {
  Row row(1);
  const std::array<QuarterMm, 4> seen{8000, 8100, 7900, 8060};
  const std::array<QuarterMm, 4> mean{8000, 8050, 8000, 8015};
  const std::array<int, 4> published{8000, 8100, 7900, 8015};  // the fourth is the first mean
  const std::array<int, 4> scatter{0, 100, 125, 103};          // of 100; 150; 60
  for (std::size_t i = 0; i < seen.size(); ++i) {
    row.depth[0] = seen[i];
    row.width[0] = 800;
    row.source[0] = Source::kPmd;
    best::temporal_row(row.row(), {}, row.state());
    EXPECT_EQ(row.depth[0], published[i]) << i;
    EXPECT_EQ(row.width[0], 800) << i;
    EXPECT_EQ(row.mean[0], mean[i]) << i;
    EXPECT_EQ(row.scatter[0] / kMeanOne, scatter[i]) << i;
    EXPECT_EQ(row.tally[0] % kMeanOne, i + 1);
    EXPECT_EQ(row.kind[0] % 8, static_cast<int>(Source::kPmd));
  }
}

TEST(TemporalRow, NoDepthIsNeverFilledWhateverItsWidthSays) {
  Row row(1);
  for (int frame = 0; frame < 10; ++frame) {
    row.depth[0] = static_cast<QuarterMm>(40 + frame % 2);
    row.width[0] = 800;
    best::temporal_row(row.row(), {}, row.state());
  }
  row.depth[0] = kNoDepth;
  best::temporal_row(row.row(), {}, row.state());
  EXPECT_EQ(row.depth[0], kNoDepth);
  EXPECT_EQ(row.tally[0], 0);
  EXPECT_EQ(row.mean[0], 0);
}

TEST(TemporalRow, EqualsReferenceForEveryLengthOverManyFrames) {
  int narrowed = 0;
  int moved = 0;
  bool compared = false;
  for (const Scene scene : {Scene::kAnything, Scene::kStill, Scene::kCreeping}) {
    compared = test::check_kernel([&](test::KernelCase& c) {
      const std::size_t n = c.length();
      const TemporalLimits limits{
          .frames = static_cast<std::uint8_t>(n % 3 == 0 ? c.draw(1, kMostFrames) : 8),
          .max_step = static_cast<QuarterMm>(n % 4 == 0 ? c.draw(0, kMostStep) : kMostStep)};
      const TemporalState state{.mean = c.array<QuarterMm>(n, 0, 0),
                                .scatter = c.array<std::uint16_t>(n, 0, 0),
                                .tally = c.array<std::uint8_t>(n, 0, 0),
                                .kind = c.array<std::uint8_t>(n, 0, 0)};
      for (int frame = 0; frame < 16; ++frame) {
        const TemporalRow row = next_frame(scene, frame, c);
        const std::vector<QuarterMm> depth(row.depth.begin(), row.depth.end());
        const std::vector<QuarterMm> width(row.width.begin(), row.width.end());
        c.run([&] { best::temporal_row(row, limits, state); });
        for (std::size_t x = 0; x < n; ++x) {
          narrowed += row.width[x] < width[x] ? 1 : 0;
          moved += row.depth[x] != depth[x] ? 1 : 0;
        }
      }
    });
  }
  if (compared) {
    EXPECT_GT(narrowed, 1000);
    EXPECT_GT(moved, 10000);
  }
}

}  // namespace
}  // namespace stof::dsp
