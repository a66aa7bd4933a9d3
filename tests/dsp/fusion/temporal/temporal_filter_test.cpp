#include "dsp/fusion/temporal/temporal_filter.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <vector>

#include <gtest/gtest.h>

#include "dsp/fusion/temporal/picture_change.h"
#include "tests/support/guarded_memory.h"
#include "tests/support/guarded_part.h"
#include "tests/support/random.h"

namespace stof::dsp {
namespace {

constexpr double kMmPerQuarter = 0.25;
constexpr double kFramesPerSecond = 30;

// A filter, the pictures beside it, the frame that goes through it and what was measured.
class Stage {
 public:
  Stage(int width, int height, const TemporalParams& params = {})
      : filter_([&](Arena& arena) { return TemporalFilter(width, height, params, arena); }),
        change_([&](Arena& arena) { return PictureChange(width, height, arena); }),
        grey_(width, height, width + 3, 100),
        depth_(width, height, width + 5),
        width_(width, height, width),
        source_(width, height, width + 1, Source::kBoth),
        measured_(static_cast<std::size_t>(width) * static_cast<std::size_t>(height)),
        widths_(measured_.size()) {}

  ImageView<std::uint8_t> grey() { return grey_.view(); }
  ImageView<QuarterMm> depth() { return depth_.view(); }
  ImageView<QuarterMm> width() { return width_.view(); }
  ImageView<Source> source() { return source_.view(); }
  void forget() { change_->forget(); }
  int measured(int x, int y) { return measured_[index(x, y)]; }
  int measured_width(int x, int y) { return widths_[index(x, y)]; }

  // value(x, y) is the depth of each pixel.
  template <typename Value>
  void put(int width, Value value) {
    each([&](int x, int y) {
      depth().at(x, y) = static_cast<QuarterMm>(value(x, y));
      this->width().at(x, y) = static_cast<QuarterMm>(width);
    });
  }
  void run() {
    each([&](int x, int y) {
      measured_[index(x, y)] = depth().at(x, y);
      widths_[index(x, y)] = width().at(x, y);
    });
    const bool goes_on = change_->look(grey());
    std::vector<std::uint8_t> marks(static_cast<std::size_t>(grey().width()), 255);
    for (int y = 0; y < grey().height(); ++y) {
      if (goes_on) {
        change_->mark(y, marks);
      }
      filter_->filter(y, marks, {.depth = depth(), .width = width(), .source = source()});
    }
  }
  void run_flat(int depth, int width = 400) {
    put(width, [depth](int, int) { return depth; });
    run();
  }
  bool as_measured(int x, int y) {
    return depth().at(x, y) == measured(x, y) && width().at(x, y) == measured_width(x, y);
  }
  template <typename Do>
  void each(Do act) {
    for (int y = 0; y < grey().height(); ++y) {
      for (int x = 0; x < grey().width(); ++x) {
        act(x, y);
      }
    }
  }

 private:
  std::size_t index(int x, int y) {
    return static_cast<std::size_t>(y) * static_cast<std::size_t>(grey().width()) +
           static_cast<std::size_t>(x);
  }

  test::GuardedPart<TemporalFilter> filter_;
  test::GuardedPart<PictureChange> change_;
  test::GuardedImage<std::uint8_t> grey_;
  test::GuardedImage<QuarterMm> depth_, width_;
  test::GuardedImage<Source> source_;
  std::vector<int> measured_, widths_;
};

double normal(test::Random& random) {
  constexpr int kTerms = 12;  // of variance 1/12 each
  double sum = -kTerms / 2.0;
  for (int i = 0; i < kTerms; ++i) {
    sum += random.between(0, 1 << 20) / static_cast<double>(1 << 20);
  }
  return sum;
}

struct World {
  double noise = 0;     // sigma, quarter mm
  double bias = 0;      // quarter mm
  double approach = 0;  // quarter mm a frame
  int width = 320;
};

struct Score {
  double sigma = 0;  // of what is published
  double held = 0;   // share of published intervals with the truth
  double held_before = 0;
  double width = 0;  // mean, of the measured one
};

Score watch(const World& world, std::uint64_t seed) {
  constexpr int kFrames = 50;
  constexpr int kSettled = 20;
  Stage stage(40, 30);
  test::Random random(seed);
  double sum = 0;
  double squares = 0;
  double count = 0;
  Score score;
  for (int frame = 0; frame < kFrames; ++frame) {
    const double truth = 24000 - world.approach * frame;
    stage.put(world.width, [&](int, int) {
      return std::lround(truth + world.bias + world.noise * normal(random));
    });
    stage.run();
    stage.each([&](int x, int y) {
      if (frame < kSettled) {
        return;
      }
      const double error = stage.depth().at(x, y) - truth;
      sum += error;
      squares += error * error;
      score.held += std::abs(error) <= stage.width().at(x, y) / 2.0 ? 1 : 0;
      score.held_before += std::abs(stage.measured(x, y) - truth) <= world.width / 2.0 ? 1 : 0;
      score.width += stage.width().at(x, y);
      ++count;
    });
  }
  score.sigma = std::sqrt(squares / count - sum * sum / count / count);
  score.held /= count;
  score.held_before /= count;
  score.width /= count * world.width;
  return score;
}

// sigma is a quarter of the width where noise is all there is; 8 frames of half of that must come
// out as a third, and the interval must not be narrower than what noise alone explains.
TEST(TemporalFilter, NoiseFallsByTheRootOfTheFrames) {
  const World world{.noise = 40};
  const Score score = watch(world, 1);
  EXPECT_LT(score.sigma, world.noise / std::sqrt(8.0));
  EXPECT_GT(score.held, 0.99);
  EXPECT_GT(score.width, 0.95);
}

TEST(TemporalFilter, NoiseThatFillsTheIntervalNarrowsItAndTheTruthStaysInside) {
  const World world{.noise = 80};
  const Score score = watch(world, 2);
  EXPECT_LT(score.sigma, world.noise * 0.6);  // published within one sigma of each frame
  EXPECT_GT(score.held, 0.95);
  EXPECT_LT(score.width, 0.9);
  EXPECT_GT(score.width, 0.5);
}

// The rest of the interval, (half - bias) / 1.645, is noise: 95 percent before.
TEST(TemporalFilter, AConstantErrorOfHalfTheIntervalStaysInside) {
  for (const double bias : {-80.0, 80.0}) {
    const Score score = watch({.noise = 48.6, .bias = bias}, 3);
    EXPECT_NEAR(score.held_before, 0.95, 0.01);
    EXPECT_GT(score.held, 0.95);
  }
}

TEST(TemporalFilter, ErrorsThatDoNotScatterDoNotNarrow) {
  for (const double bias : {0.0, 80.0, 150.0}) {
    const Score score = watch({.noise = 5, .bias = bias}, 4);
    EXPECT_EQ(score.width, 1.0);
    EXPECT_GE(score.held, score.held_before - 0.005);
  }
}

TEST(TemporalFilter, IntervalsNarrowToHalfAtMost) {
  Stage stage(20, 3);
  for (int frame = 0; frame < 40; ++frame) {
    stage.run_flat(frame % 2 == 0 ? 8000 : 8280);
    stage.each([&](int x, int y) {
      ASSERT_EQ(stage.width().at(x, y), frame < kFramesToNarrow - 1 ? 400 : 200) << frame;
    });
  }
}

TEST(TemporalFilter, AJumpIsPublishedAtOnce) {
  for (const int to : {8000 + 301, 8000 - 301, 20000, 1, 65535}) {
    Stage stage(37, 4);
    for (int frame = 0; frame < 20; ++frame) {
      stage.run_flat(8000 + frame % 2);
    }
    stage.run_flat(to);
    stage.each([&](int x, int y) { ASSERT_TRUE(stage.as_measured(x, y)) << to; });
    stage.run_flat(to + 20);  // nor does the old depth come back
    stage.run_flat(to - 20);
    stage.each([&](int x, int y) { ASSERT_TRUE(stage.as_measured(x, y)) << to; });
  }
}

TEST(TemporalFilter, WhatMovesFurtherThanTheLimitBeginsAnewHoweverNoisy) {
  Stage stage(37, 4);
  for (int frame = 0; frame < 20; ++frame) {
    stage.run_flat(20000 + frame % 2, 4000);
  }
  stage.run_flat(21202, 4000);
  stage.each([&](int x, int y) { ASSERT_TRUE(stage.as_measured(x, y)); });
}

TEST(TemporalFilter, AMovingEdgeBeginsAnewWhereDepthIsTheSame) {
  constexpr int kEdge = 21;
  Stage stage(40, 9);
  for (int frame = 0; frame < 20; ++frame) {
    stage.run_flat(8000 + frame % 2 * 40);
  }
  stage.grey().at(kEdge, 4) = 113;
  stage.run_flat(8100);
  stage.each([&](int x, int y) {
    const bool near = std::abs(x - kEdge) <= 1 && std::abs(y - 4) <= 1;
    ASSERT_EQ(stage.depth().at(x, y) == 8100, near) << x << " " << y;
  });
  stage.run_flat(8000);  // still so: the mean of these pixels is young
  EXPECT_EQ(stage.depth().at(kEdge, 4), 8000);
  EXPECT_NE(stage.depth().at(kEdge + 2, 4), 8000);
}

TEST(TemporalFilter, SmallChangesOfThePictureAddUp) {
  Stage stage(20, 3);
  int begun = 0;
  for (int frame = 0; frame < 40; ++frame) {
    stage.each(
        [&](int x, int y) { stage.grey().at(x, y) = static_cast<std::uint8_t>(50 + frame); });
    stage.run_flat(frame % 2 == 0 ? 8000 : 8040);
    begun += frame > 4 && stage.as_measured(5, 1) ? 1 : 0;
  }
  EXPECT_GE(begun, 6);  // twice, with four frames each less the last
}

TEST(TemporalFilter, AMissingDepthStaysMissingAndEndsTheMean) {
  Stage stage(20, 3);
  for (int frame = 0; frame < 20; ++frame) {
    stage.run_flat(8000 + frame % 2 * 40);
  }
  stage.run_flat(kNoDepth, 0);
  stage.each([&](int x, int y) {
    ASSERT_EQ(stage.depth().at(x, y), kNoDepth);
    ASSERT_EQ(stage.width().at(x, y), 0);
  });
  for (const int depth : {8100, 8000, 8060}) {
    stage.run_flat(depth);
    stage.each([&](int x, int y) { ASSERT_TRUE(stage.as_measured(x, y)) << depth; });
  }
  stage.run_flat(8100);
  EXPECT_EQ(stage.depth().at(7, 1), 8065);
}

TEST(TemporalFilter, AnotherSensorAndForgettingBeginAnew) {
  for (const int way : {0, 1}) {
    Stage stage(20, 3);
    for (int frame = 0; frame < 20; ++frame) {
      stage.run_flat(8000 + frame % 2 * 40);
    }
    if (way == 0) {
      stage.each([&](int x, int y) { stage.source().at(x, y) = Source::kStereo; });
    } else {
      stage.forget();
    }
    for (const int depth : {8060, 8000, 8060}) {
      stage.run_flat(depth);
      stage.each([&](int x, int y) { ASSERT_TRUE(stage.as_measured(x, y)) << way; });
    }
    EXPECT_EQ(stage.source().at(3, 1), way == 0 ? Source::kStereo : Source::kBoth);
  }
}

// Frame by frame the same as from a filter that has seen nothing.
TEST(TemporalFilter, AfterForgettingTheNextFrameIsAFirstFrame) {
  Stage used(20, 3);
  Stage fresh(20, 3);
  const auto frame = [](Stage& stage, std::uint64_t seed) {
    test::Random random(seed);
    stage.each([&](int x, int y) {
      stage.grey().at(x, y) = static_cast<std::uint8_t>(random.between(90, 104));
      stage.source().at(x, y) = random.between(0, 9) == 0 ? Source::kPmd : Source::kBoth;
    });
    stage.put(400, [&](int, int) {
      return random.between(0, 9) == 0 ? int{kNoDepth} : random.between(8000, 8200);
    });
    stage.run();
  };
  for (std::uint64_t seed = 0; seed < 20; ++seed) {
    frame(used, seed);
  }
  used.forget();
  int averaged = 0;
  for (std::uint64_t seed = 100; seed < 120; ++seed) {
    frame(used, seed);
    frame(fresh, seed);
    used.each([&](int x, int y) {
      ASSERT_EQ(used.depth().at(x, y), fresh.depth().at(x, y)) << seed;
      ASSERT_EQ(used.width().at(x, y), fresh.width().at(x, y)) << seed;
      averaged += fresh.as_measured(x, y) ? 0 : 1;
    });
  }
  EXPECT_GT(averaged, 100);
}

TEST(TemporalFilter, SurfacesThatApproachDoNotLag) {
  for (const double speed : {0.05, 0.2, 0.5, 1.0, 2.0, -2.0}) {
    const double step = speed * 1000 / kMmPerQuarter / kFramesPerSecond;
    for (const int width : {40, 200, 400, 800, 1600}) {
      Stage stage(18, 2);
      for (int frame = 0; frame < 60; ++frame) {
        stage.run_flat(static_cast<int>(std::lround(30000 - step * frame)), width);
        const int lag = std::abs(stage.depth().at(0, 0) - stage.measured(0, 0));
        ASSERT_LE(lag, width / 4) << speed << " m/s, width " << width << ", frame " << frame;
        ASSERT_GE(stage.width().at(0, 0) / 2, lag);
        if (8 * (std::abs(step) - 2) > width) {
          ASSERT_EQ(lag, 0) << speed << " m/s, width " << width << ", frame " << frame;
        }
      }
    }
  }
}

TEST(TemporalFilter, MovingNoisySurfacesStayInTheirInterval) {
  for (const double approach : {10.0, 20.0, 67.0, 133.0, 267.0}) {
    const Score noise_alone = watch({.noise = 80, .approach = approach}, 5);
    EXPECT_GT(noise_alone.held, 0.92) << approach;
    const Score usual = watch({.noise = 40, .approach = approach}, 6);
    EXPECT_GT(usual.held, 0.99) << approach;
  }
}

// Whatever comes in: what is said in the header about lag, width and missing depths.
TEST(TemporalFilter, KeepsItsPromisesWithAnything) {
  for (std::uint64_t seed = 0; seed < 60; ++seed) {
    test::Random random(seed);
    const int most = random.between(0, 1) == 0 ? 300 : 65535;
    Stage stage(random.between(1, 40), random.between(1, 6),
                {.frames = static_cast<std::uint8_t>(random.between(1, kMostFrames)),
                 .max_step = static_cast<QuarterMm>(random.between(0, kMostStep))});
    for (int frame = 0; frame < 20; ++frame) {
      stage.put(0, [&](int, int) { return random.between(0, most); });
      stage.each([&](int x, int y) {
        const int depth = stage.depth().at(x, y);
        const int widest = 2 * std::min(depth, kMaxQuarterMm - depth);
        stage.width().at(x, y) = static_cast<QuarterMm>(random.between(0, widest / 2) * 2);
        stage.grey().at(x, y) = static_cast<std::uint8_t>(random.between(0, 30));
        stage.source().at(x, y) = static_cast<Source>(random.between(0, 9) == 0 ? 2 : 3);
      });
      stage.run();
      stage.each([&](int x, int y) {
        const int depth = stage.depth().at(x, y);
        const int width = stage.width().at(x, y);
        const int old_width = stage.measured_width(x, y);
        const int lag = std::abs(depth - stage.measured(x, y));
        ASSERT_EQ(depth == kNoDepth, stage.measured(x, y) == kNoDepth) << seed;
        ASSERT_LE(lag, old_width / 4) << seed;
        ASSERT_LE(lag, width / 2) << seed;
        ASSERT_LE(width, old_width) << seed;
        ASSERT_GE(width, old_width / 2) << seed;
        ASSERT_EQ(width % 2, 0) << seed;
        ASSERT_GE(depth - width / 2, 0) << seed;
        ASSERT_LE(depth + width / 2, kMaxQuarterMm) << seed;
      });
    }
  }
}

}  // namespace
}  // namespace stof::dsp
