#include "hal/linux/camera/exposure_matcher.h"

#include <gtest/gtest.h>

namespace stof::test {
namespace {

using namespace std::chrono_literals;
using hal::linux::ExposureMatcher;
using hal::linux::MatchedExposure;

constexpr hal::Duration kPeriod = 33ms;
constexpr hal::Duration kExposure = 4ms;
constexpr hal::Duration kDelay = 5ms;  // usual
constexpr hal::Duration kMost = 25ms;

class ExposureMatcherTest : public testing::Test {
 protected:
  static hal::Time edge(int number) { return hal::Time(1s + number * kPeriod); }

  // The picture with that number, of exposure `exposed`, comes so long after the exposure's end;
  // all edges before have been noted.
  MatchedExposure come(int exposed, std::uint32_t number, hal::Duration delay = kDelay) {
    const hal::Time stamp = edge(exposed) + kExposure + delay;
    while (edge(noted_) <= stamp) {
      edges_.note(edge(noted_++));
    }
    return matcher_.match(stamp, number);
  }
  // The picture that is not believed.
  void begin(std::uint32_t number = 0) { EXPECT_FALSE(come(-1, number - 1).sure); }
  // Is of that exposure.
  static bool is(const MatchedExposure& matched, int exposed) {
    return matched.sure && matched.exposure.begin == edge(exposed) &&
           matched.exposure.end == edge(exposed) + kExposure;
  }

  hal::linux::EdgeLog edges_;
  hal::linux::EdgeExposures exposures_{edges_, kExposure};
  ExposureMatcher matcher_{exposures_, kMost};
  int noted_ = -1;
};

TEST_F(ExposureMatcherTest, FirstPictureIsNotBelievedTheSecondIs) {
  EXPECT_FALSE(come(0, 0).sure);
  EXPECT_TRUE(is(come(1, 1), 1));
}

// It looks like one of exposure 1, early in its time: nothing is to be learnt from that delay.
TEST_F(ExposureMatcherTest, FirstPictureThatIsHeldUpIsNeitherBelievedNorTheMeasure) {
  EXPECT_FALSE(come(0, 0, kPeriod + 1ms).sure);
  EXPECT_FALSE(come(1, 1, 18ms).sure);  // the second of that exposure
  for (int i = 2; i < 20; ++i) {
    EXPECT_TRUE(is(come(i, static_cast<std::uint32_t>(i), 18ms), i)) << i;
  }
}

TEST_F(ExposureMatcherTest, EachPictureIsOfItsExposure) {
  begin();
  for (int i = 0; i < 100; ++i) {
    EXPECT_TRUE(is(come(i, static_cast<std::uint32_t>(i)), i)) << i;
  }
}

TEST_F(ExposureMatcherTest, NumbersMayWrap) {
  begin(0xFFFF'FFFEU);
  for (int i = 0; i < 4; ++i) {
    EXPECT_TRUE(is(come(i, 0xFFFF'FFFEU + static_cast<std::uint32_t>(i)), i)) << i;
  }
}

TEST_F(ExposureMatcherTest, WhatTheDriverCountedAsLostCostsNoMore) {
  begin();
  EXPECT_TRUE(is(come(0, 0), 0));
  EXPECT_TRUE(is(come(3, 3), 3));
  EXPECT_TRUE(is(come(4, 4), 4));
}

TEST_F(ExposureMatcherTest, AnEdgeWithoutAPictureCostsTheNextOne) {
  begin();
  EXPECT_TRUE(is(come(0, 0), 0));
  EXPECT_FALSE(come(2, 1).sure);  // of 2, or of 1 and late: nobody knows
  EXPECT_TRUE(is(come(3, 2), 3));
  EXPECT_TRUE(is(come(4, 3), 4));
}

TEST_F(ExposureMatcherTest, PictureThatIsHeldUpUntilTheNextExposureIsNotTakenForThat) {
  for (const hal::Duration late : {34ms, 38ms, 45ms, 60ms}) {
    matcher_.forget();
    const int first = noted_ + 2;
    ASSERT_FALSE(come(first - 1, 0U - 1U).sure);
    ASSERT_TRUE(is(come(first, 0), first));
    ASSERT_TRUE(is(come(first + 1, 1), first + 1));
    EXPECT_FALSE(come(first + 2, 2, late).sure);
    EXPECT_FALSE(come(first + 3, 3, std::max(late - kPeriod + 1ms, kDelay)).sure);
    EXPECT_TRUE(is(come(first + 4, 4), first + 4));
  }
}

// Delays that are never less than a period: what comes is always of the exposure before.
TEST_F(ExposureMatcherTest, CameraThatLagsFromNowOnIsNeverBelievedAndAtLastHopeless) {
  begin();
  for (std::uint32_t i = 0; i < 10; ++i) {
    ASSERT_TRUE(is(come(static_cast<int>(i), i), static_cast<int>(i)));
  }
  for (std::uint32_t i = 10; i < 10 + ExposureMatcher::kHopeless; ++i) {
    EXPECT_FALSE(matcher_.hopeless());
    EXPECT_FALSE(come(static_cast<int>(i), i, kPeriod + 16ms).sure) << i;
  }
  EXPECT_TRUE(matcher_.hopeless());
  matcher_.forget();
  EXPECT_FALSE(matcher_.hopeless());
}

TEST_F(ExposureMatcherTest, LateBeyondMostDelayIsOfNoExposureAndTheNextOneIsBelieved) {
  begin();
  EXPECT_TRUE(is(come(0, 0), 0));
  const MatchedExposure late = come(1, 1, kMost + 1ms);
  EXPECT_FALSE(late.sure);
  EXPECT_EQ(late.exposure.begin, late.exposure.end);
  EXPECT_TRUE(is(come(2, 2), 2));
}

TEST_F(ExposureMatcherTest, AfterAPauseOfTheTriggerTheFirstPictureIsBelieved) {
  begin();
  EXPECT_TRUE(is(come(0, 0), 0));
  noted_ += 20;  // no edges
  EXPECT_TRUE(is(come(21, 1), 21));
}

TEST_F(ExposureMatcherTest, UsualDelayFollowsSlowChanges) {
  begin();
  for (int i = 0; i < 200; ++i) {
    EXPECT_TRUE(is(come(i, static_cast<std::uint32_t>(i), kDelay + i * 50us), i)) << i;
  }
  // And is used: an edge is lost.
  EXPECT_FALSE(come(201, 200, 15ms).sure);
  EXPECT_TRUE(is(come(202, 201, 15ms), 202));
}

}  // namespace
}  // namespace stof::test
