// Frames that come later than others: held back by the network, or by somebody on the way.
#include "host/client/session/frame_delay.h"

#include <chrono>
#include <cstdint>
#include <optional>

#include <gtest/gtest.h>

#include "host/client/reassembler.h"
#include "host/client/session/link_watch.h"
#include "host/client/session/stream_verifier.h"
#include "tests/host/client/sent_frame.h"

namespace stof::client {
namespace {

using namespace std::chrono_literals;
using Verdict = FrameDelay::Verdict;

constexpr Duration kPeriod = 50ms;
constexpr Duration kMost = 150ms;
constexpr Duration kSoon = 250ms;
constexpr Time kStart{1000s};

// A sensor whose clock is 7 s behind ours, and ahead of it by `drift_ppm`.
class FrameDelayTest : public testing::Test {
 protected:
  static wire::FrameStamp stamp(Duration exposed, std::int64_t drift_ppm = 0) {
    return {.exposure_middle_ns = (exposed + exposed / 1'000'000 * drift_ppm + 993s) / 1ns};
  }
  // A frame that was exposed `exposed` after the start and was on its way for so long.
  Verdict frame(Duration exposed, Duration way, std::int64_t drift_ppm = 0) {
    const wire::FrameStamp of = stamp(exposed, drift_ppm);
    delay_.note(of, kStart + exposed + way, key_, kSoon);
    return delay_.judge(of, kStart + exposed + way, kMost, signed_);
  }

  FrameDelay delay_;
  std::uint32_t key_ = 1;
  bool signed_ = true;
};

TEST_F(FrameDelayTest, TheWayMayTakeAsLongAsAFrameMayBeOld) {
  for (int i = 0; i < 100; ++i) {
    EXPECT_EQ(frame(i * kPeriod, 30ms + i % 3 * 70ms), Verdict::kTimely) << i;
  }
  EXPECT_EQ(frame(100 * kPeriod, 30ms + kMost + 3ms), Verdict::kLate);
  EXPECT_EQ(frame(101 * kPeriod, 30ms + kMost), Verdict::kTimely);
}

TEST_F(FrameDelayTest, AStreamThatIsSlowedIsRefusedForGood) {
  for (const int percent : {80, 99}) {
    delay_ = {};
    int taken = 0;
    for (int i = 0; i < 2400; ++i) {
      const Duration exposed = i * kPeriod;
      taken += frame(exposed, exposed * (100 - percent) / percent) == Verdict::kTimely ? 1 : 0;
    }
    // As many as come before they are late by 150 ms and the drift.
    const Duration late = taken * kPeriod * (100 - percent) / percent;
    EXPECT_LE(late, kMost + 20ms) << percent;
    EXPECT_GE(late, kMost - 20ms) << percent;
    EXPECT_TRUE(delay_.held_back());
  }
}

TEST_F(FrameDelayTest, ClocksMayDrift) {
  for (const std::int64_t ppm : {-190, 0, 190}) {
    delay_ = {};
    for (int i = 0; i < 100'000; ++i) {  // 83 minutes
      ASSERT_EQ(frame(i * kPeriod, 30ms, ppm), Verdict::kTimely) << ppm << " " << i;
    }
  }
}

TEST_F(FrameDelayTest, WhatSlowsByLessThanClocksDriftIsNotSeenUntilItIs) {
  Duration slept = 0s;
  int i = 0;
  for (; i < 20'000; ++i) {  // twice as fast
    slept = i * kPeriod / 1'000'000 * 400;
    if (frame(i * kPeriod, slept) != Verdict::kTimely) {
      break;
    }
  }
  EXPECT_NEAR(std::chrono::duration<double>(i * kPeriod).count(), 750, 10);
}

// The clock of arrivals stands while this machine sleeps; the sensor goes on, and so does whoever
// holds its frames.
TEST_F(FrameDelayTest, WhatWaitedWhileThisMachineSleptIsLate) {
  ASSERT_EQ(frame(0s, 30ms), Verdict::kTimely);
  delay_.slept(60s);
  const wire::FrameStamp held = stamp(kPeriod);
  delay_.note(held, kStart + kPeriod + 30ms, key_, kSoon);
  EXPECT_EQ(delay_.judge(held, kStart + kPeriod + 30ms, kMost, true), Verdict::kLate);
  const wire::FrameStamp fresh = stamp(60s + 2 * kPeriod);
  delay_.note(fresh, kStart + 2 * kPeriod + 30ms, key_, kSoon);
  EXPECT_EQ(delay_.judge(fresh, kStart + 2 * kPeriod + 30ms, kMost, true), Verdict::kTimely);
}

// The sensor's clock stood for ten seconds: all that it sends looks as if it were late.
class ClockThatStood : public FrameDelayTest {
 protected:
  static constexpr Duration kStood = 10s;
  Verdict after(Duration exposed, Duration way = 30ms) { return frame(exposed, way + kStood); }
};

TEST_F(ClockThatStood, WithoutSignaturesASecondHeals) {
  signed_ = false;
  ASSERT_EQ(frame(0s, 30ms), Verdict::kTimely);
  for (Duration at = kPeriod; at < 1s + kPeriod; at += kPeriod) {
    EXPECT_EQ(after(at), Verdict::kLate);
  }
  EXPECT_EQ(after(1s + kPeriod), Verdict::kResynchronised);
  EXPECT_EQ(after(1s + 2 * kPeriod), Verdict::kTimely);
}

TEST_F(ClockThatStood, WithSignaturesANewKeyThatComesSoonHealsAndTimeDoesNot) {
  ASSERT_EQ(frame(0s, 30ms), Verdict::kTimely);
  for (Duration at = kPeriod; at < 20s; at += kPeriod) {
    ASSERT_EQ(after(at), Verdict::kLate);
    EXPECT_EQ(delay_.held_back(), at >= 1s + kPeriod);
  }
  delay_.prove(2, kStart + kStood + 20s);
  EXPECT_EQ(after(20s), Verdict::kLate) << "the key of before signed it";
  key_ = 2;
  EXPECT_EQ(after(20s + kPeriod), Verdict::kTimely);
  EXPECT_FALSE(delay_.held_back());
}

TEST_F(ClockThatStood, WhoeverHoldsBackWhatANewKeySignsProvesNothing) {
  ASSERT_EQ(frame(0s, 30ms), Verdict::kTimely);
  Duration at = kPeriod;
  for (std::uint32_t key = 2; key < 10; ++key) {
    for (const Duration end = at + 2s; at < end; at += kPeriod) {
      ASSERT_EQ(frame(at, 1s), Verdict::kLate);
    }
    delay_.prove(key, kStart + at);  // exposed and signed after that, and a second on its way
    key_ = key;
  }
}

TEST_F(FrameDelayTest, AnEmulatedRigsTimeIsNotOurs) {
  for (int i = 0; i < 100; ++i) {
    wire::FrameStamp of = stamp(0s);
    of.clock = wire::ClockState::kEmulated;
    delay_.note(of, kStart + i * 1s, key_, kSoon);
    EXPECT_EQ(delay_.judge(of, kStart + i * 1s, kMost, true), Verdict::kTimely);
  }
}

TEST_F(FrameDelayTest, AStampMayHoldAnyNumber) {
  for (const std::int64_t ns : {INT64_MIN, INT64_MAX, std::int64_t{-1}, std::int64_t{0}}) {
    const wire::FrameStamp of{.exposure_middle_ns = ns};
    delay_.note(of, kStart, 0, kSoon);
    static_cast<void>(delay_.judge(of, kStart + 1h, kMost, false));
  }
}

// Through the reassembler: one packet a frame, by a monotonic clock.
class SlowedStream : public testing::Test {
 protected:
  static test::Datagram packet(std::uint32_t number) {
    test::Datagram datagram =
        test::datagrams({.number = number, .freshness = number, .width = 0, .height = 0}).front();
    constexpr std::size_t kClockAt = 19;
    datagram[kClockAt] = static_cast<std::byte>(wire::ClockState::kMonotonic);
    test::reseal(datagram);
    return datagram;
  }
  bool push(std::uint32_t number, Time arrived) {  // number: ms of the exposure
    reassembler_.push(packet(number), arrived);
    const bool taken = reassembler_.take(arrived).has_value();
    watch_.look(reassembler_, arrived);
    return taken;
  }

  Reassembler reassembler_;
  LinkWatch watch_{kStart};
};

TEST_F(SlowedStream, IsNotDeliveredCountedAndTold) {
  int taken = 0;
  constexpr int kFrames = 22;
  for (int i = 0; i < kFrames; ++i) {
    taken += push(static_cast<std::uint32_t>(50 * (i + 1)), kStart + i * 62ms) ? 1 : 0;
  }
  EXPECT_EQ(taken, 17) << "200 ms, at 12 ms a frame";
  EXPECT_EQ(reassembler_.statistics().frames_old, static_cast<std::uint64_t>(kFrames - taken));
  EXPECT_EQ(reassembler_.late_frames(), static_cast<std::uint64_t>(kFrames - taken));
  EXPECT_TRUE(watch_.state(kStart + kFrames * 62ms).delayed);
  EXPECT_FALSE(watch_.state(kStart + kFrames * 62ms + 2s).delayed);
}

TEST_F(SlowedStream, OneForgedStampPausesForASecondAtMost) {
  ASSERT_TRUE(push(50, kStart));
  ASSERT_TRUE(push(100, kStart + 50ms));
  test::Datagram forged = packet(150);
  forged[31] = std::byte{0x7f};  // exposed in the far future
  test::reseal(forged);
  reassembler_.push(forged, kStart + 90ms);
  static_cast<void>(reassembler_.take());
  int refused = 0;
  std::uint32_t number = 200;
  Time at = kStart + 150ms;
  for (; !push(number, at); number += 50, at += 50ms) {
    ASSERT_LT(++refused, 25);
  }
  EXPECT_EQ(reassembler_.statistics().resynchronised, 1U);
  EXPECT_TRUE(push(number + 50, at + 50ms));
}

}  // namespace
}  // namespace stof::client
