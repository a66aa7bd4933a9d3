#include "dsp/fusion/temporal/steady_row.h"

#include <algorithm>
#include <array>
#include <cstdlib>
#include <vector>

#include <gtest/gtest.h>

#include "tests/support/kernel_check.h"
#include "tests/support/random.h"

namespace stof::dsp {
namespace {

struct Interval {
  QuarterMm low = 0;
  QuarterMm high = 0;
};
constexpr Interval kSilent{};

// One pixel, frame after frame.
class Pixel {
 public:
  struct Seen {
    int depth = 0;
    int width = 0;
    Source source = Source::kNone;
    Cause cause = Cause::kNone;
  };

  // source: of what was fused, with a depth.
  Seen run(int depth, Interval stereo, Interval pmd, bool changed = false,
           Source of = Source::kBoth) {
    const std::uint8_t mark = changed ? 255 : 0;
    QuarterMm d = static_cast<QuarterMm>(depth);
    QuarterMm w = depth == 0 ? QuarterMm{0} : QuarterMm{400};
    Source source = depth == 0 ? Source::kNone : of;
    Cause cause = Cause::kNone;
    best::steady_row({.changed = {&mark, 1},
                      .stereo = {{&stereo.low, 1}, {&stereo.high, 1}},
                      .pmd = {{&pmd.low, 1}, {&pmd.high, 1}},
                      .fused = {{&d, 1}, {&w, 1}, {&source, 1}, {&cause, 1}}},
                     {}, {.depth = {&depth_, 1}, .tally = {&tally_, 1}});
    return {d, w, source, cause};
  }
  Seen run_still(int frames, int depth = 8000) {
    Seen seen;
    for (int i = 0; i < frames; ++i) {
      seen = run(depth, kSilent, kSilent);
    }
    return seen;
  }

 private:
  QuarterMm depth_ = 0;
  std::uint8_t tally_ = 0;
};

TEST(SteadyRow, PublishesWhatAgreesAsItIs) {
  Pixel pixel;
  for (const int depth : {8000, 8290, 8000, 7900, 8200}) {
    const Pixel::Seen seen = pixel.run(depth, kSilent, kSilent);
    EXPECT_EQ(seen.depth, depth);
    EXPECT_EQ(seen.width, 400);
    EXPECT_EQ(seen.source, Source::kBoth);
  }
}

// It flickers where what is around it does.
TEST(SteadyRow, AGuessThatAppearsWaitsForTheNextFrame) {
  Pixel pixel;
  for (int round = 0; round < 4; ++round) {
    const Pixel::Seen seen = pixel.run(8000, kSilent, kSilent, false, Source::kResolved);
    EXPECT_EQ(seen.depth, 0);
    EXPECT_EQ(seen.width, 0);
    EXPECT_EQ(seen.source, Source::kNone);
    for (int frame = 0; frame < 2; ++frame) {
      pixel.run(0, kSilent, kSilent);
    }
  }
  pixel.run(8000, kSilent, kSilent, false, Source::kResolved);
  EXPECT_EQ(pixel.run(8000, kSilent, kSilent, false, Source::kResolved).depth, 8000);
  Pixel other;
  EXPECT_EQ(other.run(8000, kSilent, kSilent, true, Source::kResolved).depth, 8000);
  Pixel read;
  EXPECT_EQ(read.run(8000, kSilent, kSilent).depth, 8000);
}

TEST(SteadyRow, MarksOfOtherKindsAreNoChange) {
  std::array<QuarterMm, 1> depth{20000}, width{400}, seen{8000}, nothing{0};
  std::array<std::uint8_t, 1> tally{kMostTally}, mark{1};
  std::array<Source, 1> source{Source::kBoth};
  std::array<Cause, 1> cause{};
  best::steady_row({.changed = mark,
                    .changes = 2,
                    .stereo = {nothing, nothing},
                    .pmd = {nothing, nothing},
                    .fused = {depth, width, source, cause}},
                   {}, {.depth = seen, .tally = tally});
  EXPECT_EQ(depth[0], 0);
  EXPECT_EQ(seen[0], 8000);
}

// Remembered is 8000; a sixteenth of that is 500.
TEST(SteadyRow, ADoubtedReadingCountsWhereItConfirmsWhatWasSeen) {
  struct Case {
    Interval stereo;
    Interval pmd;
    int depth;
    int width;
    Source source;
  };
  for (const Case& c : {Case{{7900, 8400}, kSilent, 8000, 800, Source::kStereo},
                        Case{kSilent, {8400, 8600}, 8400, 400, Source::kPmd},
                        Case{{9000, 9500}, {7000, 8100}, 8000, 2000, Source::kPmd},
                        Case{{8400, 8500}, {7900, 8100}, 8400, 200, Source::kStereo},
                        Case{{8501, 9000}, kSilent, 0, 0, Source::kNone},
                        Case{{9000, 8000}, kSilent, 0, 0, Source::kNone},
                        Case{kSilent, kSilent, 0, 0, Source::kNone}}) {
    Pixel pixel;
    pixel.run_still(3);
    const Pixel::Seen seen = pixel.run(0, c.stereo, c.pmd);
    EXPECT_EQ(seen.depth, c.depth);
    EXPECT_EQ(seen.width, c.width);
    EXPECT_EQ(seen.source, c.source);
  }
}

TEST(SteadyRow, NothingIsConfirmedThatWasNotSeenForThreeFramesOrWherePictureChanged) {
  for (const int frames : {0, 1, 2}) {
    Pixel pixel;
    pixel.run_still(frames);
    EXPECT_EQ(pixel.run(0, {7900, 8100}, {7900, 8100}).depth, 0) << frames;
  }
  Pixel pixel;
  pixel.run_still(10);
  EXPECT_EQ(pixel.run(0, {7900, 8100}, kSilent, true).depth, 0);
  EXPECT_EQ(pixel.run(0, {7900, 8100}, kSilent).depth, 0);
}

TEST(SteadyRow, WhatBothSensorsExcludeOrThePictureShowsIsGoneAtOnce) {
  for (const int depth : {6000, 20000}) {
    const Interval there{static_cast<QuarterMm>(depth - 200), static_cast<QuarterMm>(depth + 200)};
    Pixel both;
    both.run_still(20);
    EXPECT_EQ(both.run(depth, there, there).depth, depth);
    Pixel picture;
    picture.run_still(20);
    EXPECT_EQ(picture.run(depth, there, kSilent, true).depth, depth);
  }
}

TEST(SteadyRow, WhatOneSensorSaysElsewhereIsNotBelievedUntilItWasSeenThreeTimes) {
  for (const int depth : {6000, 20000}) {
    const Interval there{static_cast<QuarterMm>(depth - 200), static_cast<QuarterMm>(depth + 200)};
    Pixel pixel;
    pixel.run_still(20);
    for (int frame = 0; frame < 2; ++frame) {
      const Pixel::Seen seen = pixel.run(depth, there, kSilent);
      EXPECT_EQ(seen.depth, kNoDepth);
      EXPECT_EQ(seen.width, 0);
      EXPECT_EQ(seen.source, Source::kConflict);
      EXPECT_EQ(seen.cause, Cause::kContradiction);
    }
    EXPECT_EQ(pixel.run(depth, there, kSilent).depth, depth);
    EXPECT_EQ(pixel.run(8000, kSilent, kSilent).depth, 8000);  // it was not yet settled
  }
}

// The PMD's interval holds both; stereo goes from one to the other.
TEST(SteadyRow, ANearerDepthWinsSoonAFartherOneLate) {
  for (const auto& [depth, frames] : {std::pair(6000, 3), std::pair(10000, 12)}) {
    const Interval there{static_cast<QuarterMm>(depth - 200), static_cast<QuarterMm>(depth + 200)};
    Pixel pixel;
    pixel.run_still(20);
    for (int frame = 1; frame < frames; ++frame) {
      EXPECT_EQ(pixel.run(depth, there, {5000, 11000}).source, Source::kPmd) << frame;
    }
    EXPECT_EQ(pixel.run(depth, there, {5000, 11000}).depth, depth);
  }
}

TEST(SteadyRow, WhatIsNotSeenIsForgotten) {
  Pixel pixel;
  pixel.run_still(20);
  for (int frame = 0; frame < 15; ++frame) {
    EXPECT_EQ(pixel.run(0, kSilent, kSilent).depth, 0);
  }
  EXPECT_EQ(pixel.run(20000, {19000, 21000}, kSilent).depth, 20000);
}

enum class World { kAnything, kStill };

SteadyRow next_frame(World world, test::KernelCase& c) {
  const std::size_t n = c.length();
  const SteadyRow row{
      .changed = c.array<std::uint8_t>(n, 0, world == World::kAnything ? 1 : 0),
      .stereo = {c.array<QuarterMm>(n), c.array<QuarterMm>(n)},
      .pmd = {c.array<QuarterMm>(n), c.array<QuarterMm>(n)},
      .fused = {c.array<QuarterMm>(n), c.array<QuarterMm>(n), c.array<Source>(n, 0, kSources - 1),
                c.array<Cause>(n, 0, kCauses - 1)}};
  if (world == World::kAnything) {
    return row;
  }
  const auto near = [&](std::size_t x, int reach) {
    const int base = x % 5 == 0 ? 65000 : 700 * static_cast<int>(x % 80) + 60;
    const int jump = c.random().between(0, 5) == 0 ? 3000 : 0;
    return static_cast<QuarterMm>(
        std::clamp(base + jump + c.random().between(-reach, reach), 0, 65535));
  };
  const auto fill = [&](std::span<const QuarterMm> low, std::span<const QuarterMm> high) {
    for (std::size_t x = 0; x < n; ++x) {
      const_cast<QuarterMm&>(low[x]) = near(x, 600);    // NOLINT: this test's own array
      const_cast<QuarterMm&>(high[x]) = near(x, 1200);  // NOLINT
    }
  };
  fill(row.stereo.low, row.stereo.high);
  fill(row.pmd.low, row.pmd.high);
  for (std::size_t x = 0; x < n; ++x) {
    row.fused.depth[x] = c.random().between(0, 3) == 0 ? kNoDepth : near(x, 300);
    row.fused.width[x] = static_cast<QuarterMm>(c.random().between(0, 900));
  }
  return row;
}

TEST(SteadyRow, EqualsReferenceForEveryLengthOverManyFrames) {
  int found = 0;
  int withheld = 0;
  int outside = 0;
  bool compared = false;
  for (const World world : {World::kAnything, World::kStill}) {
    compared = test::check_kernel([&](test::KernelCase& c) {
      const std::size_t n = c.length();
      const SteadyLimits limits{
          .max_step = static_cast<QuarterMm>(n % 3 == 0 ? c.draw(0, 65535) : 1200),
          .max_range = static_cast<QuarterMm>(n % 4 == 0 ? c.draw(1, 65535) : 65535)};
      const SteadyState state{.depth = c.array<QuarterMm>(n, 0, 0),
                              .tally = c.array<std::uint8_t>(n, 0, 0)};
      for (int frame = 0; frame < 12; ++frame) {
        const SteadyRow row = next_frame(world, c);
        const std::vector<QuarterMm> depth(row.fused.depth.begin(), row.fused.depth.end());
        c.run([&] { best::steady_row(row, limits, state); });
        for (std::size_t x = 0; x < n; ++x) {
          found += depth[x] == kNoDepth && row.fused.depth[x] != kNoDepth ? 1 : 0;
          withheld += depth[x] != kNoDepth && row.fused.depth[x] == kNoDepth ? 1 : 0;
          // Never what no sensor allows: a depth that fused has not lies in an interval.
          if (row.fused.depth[x] != depth[x] && row.fused.depth[x] != kNoDepth) {
            const IntervalRow& from = row.fused.source[x] == Source::kStereo ? row.stereo : row.pmd;
            outside +=
                row.fused.depth[x] < from.low[x] || row.fused.depth[x] > from.high[x] ? 1 : 0;
          }
        }
      }
    });
  }
  if (compared) {
    EXPECT_GT(found, 100);
    EXPECT_GT(withheld, 100);
    EXPECT_EQ(outside, 0);
  }
}

// Fills what it is asked for, and nothing else.
struct Teller : LateIntervals {
  static void fill(LateIntervals& self, std::size_t begin, std::size_t end) noexcept {
    Teller& teller = static_cast<Teller&>(self);
    for (std::size_t x = begin; x < end; ++x) {
      teller.low[x] = teller.says.low[x];
      teller.high[x] = teller.says.high[x];
      teller.asked[x] = 1;
    }
  }
  explicit Teller(const IntervalRow& row)
      : says(row), low(row.low.size(), 0), high(low), asked(low.size(), 0) {
    tell = &Teller::fill;
  }
  IntervalRow says;
  std::vector<QuarterMm> low;
  std::vector<QuarterMm> high;
  std::vector<std::uint8_t> asked;
};

TEST(SteadyRow, AsksLateIntervalsForFewPixelsAndDecidesAsWithAll) {
  constexpr std::size_t kPixels = 333;  // whole vectors and a tail of each kind
  test::Random random(7);
  struct Row {
    std::vector<QuarterMm> depth, width, seen;
    std::vector<Source> source;
    std::vector<Cause> cause;
    std::vector<std::uint8_t> tally;
  };
  Row early{.depth = std::vector<QuarterMm>(kPixels, 8000),
            .width = std::vector<QuarterMm>(kPixels, 400),
            .seen = std::vector<QuarterMm>(kPixels, 8000),
            .source = std::vector<Source>(kPixels, Source::kBoth),
            .cause = std::vector<Cause>(kPixels),
            .tally = std::vector<std::uint8_t>(kPixels, kMostTally)};
  std::vector<QuarterMm> low(kPixels);
  std::vector<QuarterMm> high(kPixels);
  const std::vector<QuarterMm> nothing(kPixels, 0);
  const std::vector<std::uint8_t> unchanged(kPixels, 0);
  for (std::size_t x = 0; x < kPixels; ++x) {
    low[x] = static_cast<QuarterMm>(random.between(7000, 9000));
    high[x] = static_cast<QuarterMm>(low[x] + 300);
    if (x >= 100 && x < 110) {
      early.depth[x] = random.between(0, 1) == 0 ? kNoDepth : QuarterMm{12000};
    }
  }
  early.depth[kPixels - 1] = 12000;
  Row late = early;
  Teller teller({low, high});
  const auto run = [&](Row& row, const IntervalRow& stereo, LateIntervals* told) {
    best::steady_row({.changed = unchanged,
                      .stereo = stereo,
                      .pmd = {nothing, nothing},
                      .fused = {row.depth, row.width, row.source, row.cause},
                      .late = told},
                     {}, {.depth = row.seen, .tally = row.tally});
  };
  run(early, {low, high}, nullptr);
  run(late, {teller.low, teller.high}, &teller);
  EXPECT_EQ(early.depth, late.depth);
  EXPECT_EQ(early.width, late.width);
  EXPECT_EQ(early.source, late.source);
  EXPECT_EQ(early.cause, late.cause);
  EXPECT_EQ(early.seen, late.seen);
  EXPECT_EQ(early.tally, late.tally);
  const auto asked = std::ranges::count(teller.asked, std::uint8_t{1});
  EXPECT_GE(asked, 11);
  EXPECT_LE(asked, 11 + 3 * 16);
  EXPECT_EQ(teller.asked[kPixels - 1], 1);
}

}  // namespace
}  // namespace stof::dsp
