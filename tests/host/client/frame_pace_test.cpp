#include "host/client/session/frame_pace.h"

#include <chrono>

#include <gtest/gtest.h>

namespace stof::client {
namespace {

using namespace std::chrono_literals;

constexpr Duration kPeriod = 33ms;

// A sensor that tells its period with its first frame and then once a second.
class FramePaceTest : public testing::Test {
 protected:
  void frames(int count, Duration apart, Duration told, std::uint32_t settings = 1) {
    for (int k = 0; k < count; ++k) {
      now_ += apart;
      if (now_ >= due_ || told != told_) {
        told_ = told;
        due_ = now_ + 1s;
        pace_.tell(told);
      }
      frame(settings);
    }
  }
  void frame(std::uint32_t settings = 1, std::uint32_t session = 1) {
    pace_.note(now_, MadeWith{.session = session, .settings = settings});
  }

  FramePace pace_;
  Time now_{100s};
  Time due_{0s};
  Duration told_{0};
};

TEST_F(FramePaceTest, BelievesASecondBeforeTheSecondFrame) {
  EXPECT_EQ(pace_.believed(), 0s);
  pace_.tell(kPeriod);
  EXPECT_EQ(pace_.believed(), kPeriod);
  pace_ = FramePace();
  pace_.tell(60s);
  EXPECT_EQ(pace_.believed(), 1s);
  frame();
  EXPECT_EQ(pace_.believed(), 1s);
}

TEST_F(FramePaceTest, ALongerPeriodThanFramesComeApartIsNotBelieved) {
  frames(2, kPeriod, 1h);
  EXPECT_EQ(pace_.believed(), kPeriod + kPeriod / 8);
}

TEST_F(FramePaceTest, ALongerPeriodThanTheSensorGoesOnTellingIsNotBelievedWhateverGapsThereAre) {
  for (const Duration gap : {Duration(100ms), Duration(1s), Duration(2s), Duration(20s)}) {
    frames(60, kPeriod, kPeriod);
    now_ += gap;
    frame();
    for (int lie = 0; lie < 60; ++lie) {
      frames(1, kPeriod, kPeriod);
      pace_.tell(60s);
      EXPECT_EQ(pace_.believed(), kPeriod) << gap;
    }
  }
}

TEST_F(FramePaceTest, AMuchShorterPeriodThanFramesComeApartIsNotBelieved) {
  frames(60, 100ms, 100ms);
  for (const Duration lie : {Duration(1ns), Duration(1ms), Duration(50ms)}) {
    pace_.tell(lie);
    EXPECT_EQ(pace_.believed(), 75ms) << lie;
  }
  frames(60, 100ms, 100ms);
  EXPECT_EQ(pace_.believed(), 100ms);
}

TEST_F(FramePaceTest, FollowsAPeriodThatFramesBearOut) {
  frames(100, kPeriod, kPeriod, 1);
  frames(2, 20s, 20s, 2);
  EXPECT_EQ(pace_.believed(), 20s);
  EXPECT_EQ(pace_.told(), 20s);
}

// As the settings make it longer and shorter: from the second frame on, and within a second.
TEST_F(FramePaceTest, FollowsTheSensorThroughItsPeriods) {
  std::uint32_t settings = 1;
  frames(100, kPeriod, kPeriod, settings);
  for (const Duration period : {Duration(100ms), Duration(2s), Duration(500ms), kPeriod,
                                Duration(1s), Duration(2s), kPeriod}) {
    frames(2, period, period, ++settings);
    const int second = static_cast<int>(1s / period);
    for (int k = 0; k < second + 20; ++k) {
      EXPECT_GE(pace_.believed(), period) << k << " after the second with " << period;
      frames(1, period, period, settings);
    }
    EXPECT_EQ(pace_.believed(), period);
  }
}

TEST_F(FramePaceTest, AGapInWhichFramesWereRefusedCountsForNothing) {
  frames(60, kPeriod, kPeriod, 1);
  pace_.interrupt();
  now_ += 1s;
  frame(2);  // of other settings: what was told before does not hold
  pace_.tell(60s);
  EXPECT_EQ(pace_.believed(), kPeriod + kPeriod / 8);
}

TEST_F(FramePaceTest, OneFrameOfOtherSettingsOrAnotherStartForgetsNothing) {
  frames(60, kPeriod, kPeriod, 1);
  now_ += 2s;
  frame(1);
  for (int lie = 0; lie < 60; ++lie) {
    frame(lie % 2 == 0 ? 7 : 1, lie % 2 == 0 ? 1 : 9);
    pace_.tell(60s);
    frames(1, kPeriod, kPeriod, 1);
    EXPECT_EQ(pace_.believed(), kPeriod);
  }
}

// Where the network or the reader stalls, frames come at once: that is not their pace.
TEST_F(FramePaceTest, FramesThatComeAtOnceAfterAStallMakeNobodyImpatient) {
  frames(100, kPeriod, kPeriod);
  now_ += 29 * kPeriod;
  for (int k = 0; k < 30; ++k) {
    now_ += 1us;
    frame();
  }
  EXPECT_EQ(pace_.believed(), kPeriod);
  frames(100, kPeriod, kPeriod);
  EXPECT_EQ(pace_.believed(), kPeriod);
}

TEST_F(FramePaceTest, WhereHalfOfTheFramesAreLostTheToldPeriodHolds) {
  frames(100, 2 * kPeriod, kPeriod);
  EXPECT_GE(pace_.believed(), kPeriod);
  EXPECT_LE(pace_.believed(), 2 * kPeriod);
}

}  // namespace
}  // namespace stof::client
