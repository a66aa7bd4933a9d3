#include "dsp/fusion/temporal/past_frames.h"

#include <gtest/gtest.h>

#include "tests/support/guarded_memory.h"
#include "tests/support/guarded_part.h"

namespace stof::dsp {
namespace {

constexpr int kWidth = 64;
constexpr int kHeight = 48;
constexpr int kThreads = 2;

// A wall at 2 m, which the PMD camera sees alone.
class Stage {
 public:
  Stage()
      : filter_([](Arena& arena) { return PastFrames(kWidth, kHeight, 40000, arena, kThreads); }),
        grey_(kWidth, kHeight, kWidth, 100),
        depth_(kWidth, kHeight, kWidth),
        width_(kWidth, kHeight, kWidth),
        source_(kWidth, kHeight, kWidth, Source::kPmd),
        cause_(kWidth, kHeight, kWidth),
        nothing_(kWidth, kHeight, kWidth),
        low_(kWidth, kHeight, kWidth),
        high_(kWidth, kHeight, kWidth) {}

  PastFrames& filter() { return *filter_; }
  ImageView<std::uint8_t> grey() { return grey_.view(); }
  // depth: what was fused, or none; heard: what the PMD says, +-200.
  int run(int depth, int heard) {
    for (int y = 0; y < kHeight; ++y) {
      for (int x = 0; x < kWidth; ++x) {
        depth_.view().at(x, y) = static_cast<QuarterMm>(depth);
        width_.view().at(x, y) = depth == 0 ? 0 : 400;
        source_.view().at(x, y) = depth == 0 ? Source::kConflict : Source::kPmd;
        low_.view().at(x, y) = static_cast<QuarterMm>(heard == 0 ? 0 : heard - 200);
        high_.view().at(x, y) = static_cast<QuarterMm>(heard == 0 ? 0 : heard + 200);
      }
    }
    filter_->look(grey());
    for (int y = kHeight - 1; y >= 0; --y) {  // in any order
      filter_->filter(y, y % kThreads,
                      {{nothing_.view().row(y), nothing_.view().row(y)},
                       {low_.view().row(y), high_.view().row(y)}},
                      {depth_.view(), width_.view(), source_.view(), cause_.view()});
    }
    return depth_.view().at(kWidth / 2, kHeight / 2);
  }
  void stand(int frames = 10) {
    for (int frame = 0; frame < frames; ++frame) {
      EXPECT_EQ(run(8000, 8000), 8000);
    }
  }
  void paint(int begin, int end, int level) {
    for (int y = 0; y < kHeight; ++y) {
      for (int x = begin; x < end; ++x) {
        grey().at(x, y) = static_cast<std::uint8_t>(level);
      }
    }
  }

 private:
  test::GuardedPart<PastFrames> filter_;
  test::GuardedImage<std::uint8_t> grey_;
  test::GuardedImage<QuarterMm> depth_, width_;
  test::GuardedImage<Source> source_;
  test::GuardedImage<Cause> cause_;
  test::GuardedImage<QuarterMm> nothing_, low_, high_;
};

TEST(PastFrames, ADoubtedReadingOfWhatStandsIsPublished) {
  Stage stage;
  EXPECT_EQ(stage.run(0, 8000), 0);
  stage.stand();
  EXPECT_EQ(stage.run(0, 8100), 8000);
  EXPECT_EQ(stage.run(0, 0), 0);      // never without a reading
  EXPECT_EQ(stage.run(0, 12000), 0);  // never against it
}

TEST(PastFrames, SaysForHowManyFramesTheCameraStood) {
  Stage stage;
  EXPECT_EQ(stage.filter().frames(), 0);
  stage.stand(7);
  EXPECT_EQ(stage.filter().frames(), 7);
  stage.paint(0, kWidth, 120);
  stage.run(8000, 8000);
  EXPECT_EQ(stage.filter().frames(), 1);
}

TEST(PastFrames, AMovedCameraAndAGapBeginAnew) {
  for (const int way : {0, 1}) {
    Stage stage;
    stage.stand();
    if (way == 0) {
      stage.paint(0, kWidth / 2, 120);
    } else {
      stage.filter().forget();
      EXPECT_EQ(stage.filter().frames(), 0);
    }
    EXPECT_EQ(stage.run(0, 8000), 0) << way;
    EXPECT_EQ(stage.run(20000, 20000), 20000) << way;
  }
}

// A moving camera remembers nothing; its maps stay as they are.
TEST(PastFrames, CountFromTheFirstFrameInWhichTheCameraStandsAgain) {
  Stage stage;
  stage.stand();
  for (int level = 120; level < 220; level += 20) {
    stage.paint(0, kWidth, level);
    EXPECT_EQ(stage.run(9000, 9000), 9000);
    EXPECT_EQ(stage.filter().frames(), 1);
  }
  EXPECT_EQ(stage.run(0, 9000), 0);
  for (int frame = 2; frame < 12; ++frame) {
    EXPECT_EQ(stage.run(8000, 8000), 8000);
    EXPECT_EQ(stage.filter().frames(), frame);
  }
  EXPECT_EQ(stage.run(0, 8100), 8000);
}

TEST(PastFrames, WithoutAPictureTheMapStaysAsItIs) {
  Stage stage;
  stage.stand();
  stage.filter().look({});
  EXPECT_EQ(stage.filter().frames(), 0);
  EXPECT_EQ(stage.run(0, 8000), 0);
}

// The box's outline changes the picture; its own middle looks like the wall behind.
TEST(PastFrames, WhatHasLeftIsGoneAtOnceWhereThePictureSaysSo) {
  Stage stage;
  stage.paint(28, 36, 130);
  stage.stand();
  stage.paint(28, 36, 100);
  EXPECT_EQ(stage.run(0, 8000), 0);
  EXPECT_EQ(stage.run(16000, 16000), 16000);
  EXPECT_GT(stage.filter().frames(), 10);
}

}  // namespace
}  // namespace stof::dsp
