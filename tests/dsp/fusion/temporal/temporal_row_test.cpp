#include "dsp/fusion/temporal/temporal_row.h"

#include <algorithm>
#include <array>

#include <gtest/gtest.h>

#include "tests/support/guarded.h"
#include "tests/support/random.h"

namespace stof::dsp {
namespace {

using Bytes = test::GuardedBuffer<std::uint8_t>;
using Words = test::GuardedBuffer<std::uint16_t>;

// A row and what is remembered of it, in memory that ends at an unreadable page.
struct Row {
  explicit Row(std::size_t n)
      : grey(n),
        above(n + 2),
        here(n + 2),
        below(n + 2),
        source(n),
        depth(n),
        width(n),
        mean(n),
        scatter(n),
        tally(n),
        kind(n),
        then(n) {}

  TemporalRow row() {
    return {.grey = grey.span(),
            .change = {above.span(), here.span(), below.span()},
            .source = source.span(),
            .depth = depth.span(),
            .width = width.span()};
  }
  TemporalState state() {
    return {.mean = mean.span(),
            .scatter = scatter.span(),
            .tally = tally.span(),
            .kind = kind.span(),
            .grey = then.span()};
  }
  // The frame of another row, with this row's own past.
  void take_frame(Row& from) {
    std::ranges::copy(from.grey.span(), grey.span().begin());
    std::ranges::copy(from.above.span(), above.span().begin());
    std::ranges::copy(from.here.span(), here.span().begin());
    std::ranges::copy(from.below.span(), below.span().begin());
    std::ranges::copy(from.source.span(), source.span().begin());
    std::ranges::copy(from.depth.span(), depth.span().begin());
    std::ranges::copy(from.width.span(), width.span().begin());
  }
  bool same_results(Row& other) {
    return std::ranges::equal(depth.span(), other.depth.span()) &&
           std::ranges::equal(width.span(), other.width.span()) &&
           std::ranges::equal(mean.span(), other.mean.span()) &&
           std::ranges::equal(scatter.span(), other.scatter.span()) &&
           std::ranges::equal(tally.span(), other.tally.span()) &&
           std::ranges::equal(kind.span(), other.kind.span()) &&
           std::ranges::equal(then.span(), other.then.span());
  }

  Bytes grey, above, here, below;
  test::GuardedBuffer<Source> source;
  Words depth, width, mean, scatter;
  Bytes tally, kind, then;
};

enum class Scene { kAnything, kStill, kCreeping };

void next_frame(Scene scene, int frame, test::Random& random, Row& row) {
  random.fill(row.grey.span());
  for (Bytes* const change : {&row.above, &row.here, &row.below}) {
    random.fill(change->span(), 0, scene == Scene::kAnything ? 255 : 12);
    change->span().front() = 0;
    change->span().back() = 0;
  }
  for (std::size_t x = 0; x < row.depth.size(); ++x) {
    const int at = static_cast<int>(x);
    row.source[x] = Source::kBoth;
    if (scene == Scene::kAnything) {
      row.source[x] = static_cast<Source>(random.between(0, 255));
      row.depth[x] = static_cast<QuarterMm>(random.next());
      row.width[x] = static_cast<QuarterMm>(random.next());
      continue;
    }
    // Also where a mean or an interval would leave u16.
    const int base = at % 5 == 0 ? 65535 - 60 * at : 60 + 700 * at % 50000;
    const int creep = scene == Scene::kCreeping ? frame * at % 90 : 0;
    const int width = at % 7 == 0 ? 65535 : 40 * at;
    row.width[x] = static_cast<QuarterMm>(width);
    const int noise = random.between(-width / 4, width / 4);
    row.depth[x] = static_cast<QuarterMm>(std::clamp(base + creep + noise, 1, 65535));
    if (random.between(0, 40) == 0) {
      row.depth[x] = kNoDepth;
    }
  }
}

TEST(GreyChange, IsTheAmountInEitherDirection) {
  const std::array<std::uint8_t, 4> now{0, 255, 10, 7};
  const std::array<std::uint8_t, 4> then{255, 0, 14, 7};
  std::array<std::uint8_t, 4> change{};
  ref::grey_change(now, then, change);
  EXPECT_EQ(change, (std::array<std::uint8_t, 4>{255, 255, 4, 0}));
}

TEST(GreyChange, NeonEqualsReferenceForEveryLength) {
  for (std::size_t n = 0; n <= 100; ++n) {
    test::Random random(n);
    Bytes now(n), then(n), a(n), b(n);
    random.fill(now.span());
    random.fill(then.span());
    ref::grey_change(now.span(), then.span(), a.span());
    neon::grey_change(now.span(), then.span(), b.span());
    ASSERT_TRUE(std::ranges::equal(a.span(), b.span())) << n;
  }
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
    ref::temporal_row(row.row(), {}, row.state());
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
    ref::temporal_row(row.row(), {}, row.state());
  }
  row.depth[0] = kNoDepth;
  ref::temporal_row(row.row(), {}, row.state());
  EXPECT_EQ(row.depth[0], kNoDepth);
  EXPECT_EQ(row.tally[0], 0);
  EXPECT_EQ(row.mean[0], 0);
}

TEST(TemporalRow, NeonEqualsReferenceForEveryLengthOverManyFrames) {
  int narrowed = 0;
  int moved = 0;
  for (std::size_t n = 0; n <= 67; ++n) {
    for (const Scene scene : {Scene::kAnything, Scene::kStill, Scene::kCreeping}) {
      test::Random random(n * 3 + static_cast<std::size_t>(scene));
      const TemporalLimits limits{
          .frames = static_cast<std::uint8_t>(n % 3 == 0 ? random.between(1, kMostFrames) : 8),
          .max_step = static_cast<QuarterMm>(n % 4 == 0 ? random.between(0, kMostStep) : kMostStep),
          .max_change = static_cast<std::uint8_t>(scene == Scene::kAnything ? 255 : 12)};
      Row measured(n), a(n), b(n);
      for (int frame = 0; frame < 16; ++frame) {
        next_frame(scene, frame, random, measured);
        a.take_frame(measured);
        b.take_frame(measured);
        ref::temporal_row(a.row(), limits, a.state());
        neon::temporal_row(b.row(), limits, b.state());
        ASSERT_TRUE(a.same_results(b))
            << n << " scene " << static_cast<int>(scene) << " frame " << frame;
        for (std::size_t x = 0; x < n; ++x) {
          narrowed += a.width[x] < measured.width[x] ? 1 : 0;
          moved += a.depth[x] != measured.depth[x] ? 1 : 0;
        }
      }
    }
  }
  EXPECT_GT(narrowed, 1000);
  EXPECT_GT(moved, 10000);
}

}  // namespace
}  // namespace stof::dsp
