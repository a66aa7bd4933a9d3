#include "hal/linux/camera/placer.h"

#include <gtest/gtest.h>

namespace stof::test {
namespace {

using namespace std::chrono_literals;
using hal::linux::Placed;
using hal::linux::Placer;

constexpr hal::Duration kPeriod = 33ms;
constexpr hal::Duration kExposure = 4ms;
constexpr hal::Duration kDelay = 5ms;  // usual
constexpr hal::Duration kMost = 25ms;

class PlacerTest : public testing::Test {
 protected:
  static hal::Time edge(int number) { return hal::Time(1s + number * kPeriod); }

  // The picture with that number, of exposure `exposed`, comes so long after the exposure's end;
  // all edges before have been noted.
  Placed come(int exposed, std::uint32_t number, hal::Duration delay = kDelay) {
    const hal::Time stamp = edge(exposed) + kExposure + delay;
    while (edge(noted_) <= stamp) {
      edges_.note(edge(noted_++));
    }
    return placer_.place(stamp, number);
  }
  // The picture that is not believed.
  void begin(std::uint32_t number = 0) { EXPECT_FALSE(come(-1, number - 1).sure); }
  // Is of that exposure.
  static bool is(const Placed& placed, int exposed) {
    return placed.sure && placed.exposure.begin == edge(exposed) &&
           placed.exposure.end == edge(exposed) + kExposure;
  }

  hal::linux::EdgeLog edges_;
  hal::linux::EdgeExposures exposures_{edges_, kExposure};
  Placer placer_{exposures_, kMost};
  int noted_ = -1;
};

TEST_F(PlacerTest, FirstPictureIsNotBelievedTheSecondIs) {
  EXPECT_FALSE(come(0, 0).sure);
  EXPECT_TRUE(is(come(1, 1), 1));
}

// It looks like one of exposure 1, early in its time: nothing is to be learnt from that delay.
TEST_F(PlacerTest, FirstPictureThatIsHeldUpIsNeitherBelievedNorTheMeasure) {
  EXPECT_FALSE(come(0, 0, kPeriod + 1ms).sure);
  EXPECT_FALSE(come(1, 1, 18ms).sure);  // the second of that exposure
  for (int i = 2; i < 20; ++i) {
    EXPECT_TRUE(is(come(i, static_cast<std::uint32_t>(i), 18ms), i)) << i;
  }
}

TEST_F(PlacerTest, EachPictureIsOfItsExposure) {
  begin();
  for (int i = 0; i < 100; ++i) {
    EXPECT_TRUE(is(come(i, static_cast<std::uint32_t>(i)), i)) << i;
  }
}

TEST_F(PlacerTest, NumbersMayWrap) {
  begin(0xFFFF'FFFEU);
  for (int i = 0; i < 4; ++i) {
    EXPECT_TRUE(is(come(i, 0xFFFF'FFFEU + static_cast<std::uint32_t>(i)), i)) << i;
  }
}

TEST_F(PlacerTest, WhatTheDriverCountedAsLostCostsNoMore) {
  begin();
  EXPECT_TRUE(is(come(0, 0), 0));
  EXPECT_TRUE(is(come(3, 3), 3));
  EXPECT_TRUE(is(come(4, 4), 4));
}

TEST_F(PlacerTest, AnEdgeWithoutAPictureCostsTheNextOne) {
  begin();
  EXPECT_TRUE(is(come(0, 0), 0));
  EXPECT_FALSE(come(2, 1).sure);  // of 2, or of 1 and late: nobody knows
  EXPECT_TRUE(is(come(3, 2), 3));
  EXPECT_TRUE(is(come(4, 3), 4));
}

TEST_F(PlacerTest, PictureThatIsHeldUpUntilTheNextExposureIsNotTakenForThat) {
  for (const hal::Duration late : {34ms, 38ms, 45ms, 60ms}) {
    placer_.forget();
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
TEST_F(PlacerTest, CameraThatLagsFromNowOnIsNeverBelievedAndAtLastHopeless) {
  begin();
  for (std::uint32_t i = 0; i < 10; ++i) {
    ASSERT_TRUE(is(come(static_cast<int>(i), i), static_cast<int>(i)));
  }
  for (std::uint32_t i = 10; i < 10 + Placer::kHopeless; ++i) {
    EXPECT_FALSE(placer_.hopeless());
    EXPECT_FALSE(come(static_cast<int>(i), i, kPeriod + 16ms).sure) << i;
  }
  EXPECT_TRUE(placer_.hopeless());
  placer_.forget();
  EXPECT_FALSE(placer_.hopeless());
}

TEST_F(PlacerTest, LateBeyondMostDelayIsOfNoExposureAndTheNextOneIsBelieved) {
  begin();
  EXPECT_TRUE(is(come(0, 0), 0));
  const Placed late = come(1, 1, kMost + 1ms);
  EXPECT_FALSE(late.sure);
  EXPECT_EQ(late.exposure.begin, late.exposure.end);
  EXPECT_TRUE(is(come(2, 2), 2));
}

TEST_F(PlacerTest, AfterAPauseOfTheTriggerTheFirstPictureIsBelieved) {
  begin();
  EXPECT_TRUE(is(come(0, 0), 0));
  noted_ += 20;  // no edges
  EXPECT_TRUE(is(come(21, 1), 21));
}

TEST_F(PlacerTest, UsualDelayFollowsSlowChanges) {
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
