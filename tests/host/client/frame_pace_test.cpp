#include "host/client/session/frame_pace.h"

#include <chrono>

#include <gtest/gtest.h>

namespace stof::client {
namespace {

using namespace std::chrono_literals;

constexpr Duration kPeriod = 33ms;

// Frames that come one by one, `apart` from each other, from `at` on; then where the next one is
// due.
Time note_frames(FramePace& pace, int count, Duration apart, Time at) {
  for (int k = 0; k < count; ++k) {
    pace.note(at);
    at += apart;
  }
  return at;
}

TEST(FramePace, BelievesASecondBeforeTheSecondFrame) {
  FramePace pace;
  EXPECT_EQ(pace.believed(kPeriod), kPeriod);
  EXPECT_EQ(pace.believed(60s), 1s);
  pace.note(Time(1s));
  EXPECT_EQ(pace.believed(60s), 1s);
}

TEST(FramePace, ALongerPeriodThanFramesComeApartIsNotBelieved) {
  FramePace pace;
  note_frames(pace, 2, kPeriod, Time(1s));
  EXPECT_EQ(pace.believed(1h), kPeriod + kPeriod / 8);
  EXPECT_EQ(pace.believed(kPeriod), kPeriod);
  EXPECT_EQ(pace.believed(0ms), 0ms);
}

TEST(FramePace, FollowsAPeriodThatFramesBearOut) {
  FramePace pace;
  const Time at = note_frames(pace, 100, kPeriod, Time(1s));
  note_frames(pace, 2, 20s, at);
  EXPECT_EQ(pace.believed(20s), 20s);
  EXPECT_EQ(pace.believed(1h), 22'500ms);
}

// Where the network or the reader stalls, frames come at once: that is not their pace.
TEST(FramePace, FramesThatComeAtOnceAfterAStallMakeNobodyImpatient) {
  FramePace pace;
  const Time at = note_frames(pace, 100, kPeriod, Time(1s));
  note_frames(pace, 30, 1us, at + 29 * kPeriod);
  EXPECT_EQ(pace.believed(kPeriod), kPeriod);
}

}  // namespace
}  // namespace stof::client
