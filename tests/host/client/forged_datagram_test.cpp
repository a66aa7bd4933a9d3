// One datagram that is whole, of the right device and session, and says what no sensor can have
// counted. It costs that datagram, or a second at most.
#include <array>
#include <chrono>
#include <limits>
#include <optional>
#include <vector>

#include <gtest/gtest.h>

#include "firmware/wire/messages/event.h"
#include "firmware/wire/messages/health.h"
#include "host/client/reassembler.h"
#include "host/client/session/link_watch.h"
#include "tests/host/client/sent_frame.h"

namespace stof::client {
namespace {

using std::chrono::milliseconds;
using std::chrono::seconds;
using test::Datagram;
using test::FrameSpec;

constexpr Time kStart{seconds(100)};
constexpr milliseconds kPeriod(33);

// A sensor that sends a frame of one packet each period, and whoever forges in between.
class Forged : public testing::Test {
 protected:
  static FrameSpec spec(std::uint32_t number, std::uint32_t freshness) {
    return {.number = number, .freshness = freshness, .width = 0, .height = 0};
  }

  // How many of so many frames come.
  int send(int frames) {
    int came = 0;
    for (int i = 0; i < frames; ++i) {
      now_ += kPeriod;
      ++number_;
      came += push(spec(number_, number_)) ? 1 : 0;
    }
    return came;
  }
  bool push(const FrameSpec& frame) {
    reassembler_.push(test::datagrams(frame).front(), now_);
    return reassembler_.take(now_).has_value();
  }
  void health(std::uint64_t uptime_ms, std::uint32_t active, std::uint32_t events = 0) {
    std::array<std::byte, wire::kHealthReportBytes> payload{};
    wire::encode_health_report({.uptime_ms = uptime_ms, .active = active, .events = events},
                               payload);
    reassembler_.push(
        test::report_datagram(spec(number_, number_), wire::PacketType::kHealth, payload), now_);
  }
  bool event(std::uint32_t sequence, std::uint8_t active = 0) {
    std::array<std::byte, wire::kEventReportBytes> payload{};
    wire::encode_event_report({.sequence = sequence, .active = active}, payload);
    reassembler_.push(
        test::report_datagram(spec(number_, number_), wire::PacketType::kEvent, payload), now_);
    return reassembler_.take_event().has_value();
  }
  void calibration(std::uint32_t number, std::int32_t fx) {
    reassembler_.push(test::calibration_datagram(spec(number, number), 33'000'000, fx), now_);
  }

  Reassembler reassembler_;
  Time now_ = kStart;
  std::uint32_t number_ = 1000;
};

TEST_F(Forged, AFrameNumberFarAheadStopsNothing) {
  EXPECT_EQ(send(10), 10);
  EXPECT_FALSE(push(spec(number_ + (1U << 30), number_ + 1)));
  EXPECT_EQ(send(10), 10);
  EXPECT_EQ(reassembler_.statistics().implausible, 1U);
}

TEST_F(Forged, AFreshnessFarAheadStopsNothing) {
  EXPECT_EQ(send(10), 10);
  EXPECT_FALSE(push(spec(number_ + 1, number_ + (1U << 30))));
  EXPECT_EQ(send(10), 10);
  EXPECT_EQ(reassembler_.statistics().implausible, 1U);
  EXPECT_EQ(reassembler_.statistics().frames_stale, 0U);
}

TEST_F(Forged, WhatMayJustBeCostsASecondAtMost) {
  EXPECT_EQ(send(10), 10);
  EXPECT_TRUE(push(spec(number_ + 128, number_ + 128)));
  EXPECT_GE(send(100), 100 - 31);
}

TEST_F(Forged, AFirstPacketThatLiesCostsASecond) {
  for (const std::uint32_t lie : {1U << 30, 3U << 30}) {
    reassembler_ = Reassembler();
    EXPECT_TRUE(push(spec(number_ + lie, number_ + lie)));
    const int came = send(60);
    EXPECT_GE(came, 60 - 31) << lie;
    EXPECT_EQ(reassembler_.statistics().resynchronised, 1U) << lie;
    EXPECT_EQ(send(60), 60) << lie;
  }
}

TEST_F(Forged, WhatRepeatsItselfIsNeverTakenForNew) {
  EXPECT_EQ(send(10), 10);
  const std::uint32_t frozen = number_;
  for (int i = 0; i < 1000; ++i) {
    now_ += kPeriod;
    ++number_;
    EXPECT_FALSE(push(spec(number_, frozen)));
  }
  EXPECT_EQ(reassembler_.statistics().frames_stale, 1000U);
  EXPECT_EQ(reassembler_.statistics().resynchronised, 0U);
  number_ += 100;
  EXPECT_EQ(send(10), 10) << "fresh again";
}

TEST_F(Forged, AnOutageOfAnyLengthIsPlausible) {
  for (const seconds outage : {seconds(1), seconds(60), seconds(3'000'000)}) {
    EXPECT_EQ(send(10), 10);
    now_ += outage;
    number_ += static_cast<std::uint32_t>(outage / kPeriod);
    EXPECT_EQ(send(10), 10);
  }
  EXPECT_EQ(reassembler_.statistics().implausible, 0U);
  EXPECT_EQ(reassembler_.statistics().resynchronised, 0U);
}

TEST_F(Forged, ACalibrationFromTheFutureIsNotTaken) {
  EXPECT_EQ(send(10), 10);
  calibration(number_, 111);
  calibration(number_ + (1U << 30), 666);
  ASSERT_TRUE(reassembler_.calibration());
  EXPECT_EQ(reassembler_.calibration()->fx, 111);
  EXPECT_EQ(send(30), 30);
  calibration(number_, 112);
  EXPECT_EQ(reassembler_.calibration()->fx, 112);
}

TEST_F(Forged, ACalibrationThatCameBeforeTheFirstFrameIsReplacedByTheNext) {
  calibration(number_ + (1U << 30), 666);
  EXPECT_EQ(send(30), 30);
  calibration(number_, 111);
  EXPECT_EQ(reassembler_.calibration()->fx, 111);
}

// The same, looked at as a receiver does.
class ForgedPeriod : public Forged {
 protected:
  FrameSpec made(std::uint32_t settings = 0) const {
    FrameSpec frame = spec(number_, number_);
    frame.calibration = 77;
    frame.settings = settings;
    return frame;
  }
  // A frame a period, with the true calibration before every tenth.
  void stream(int frames, Duration period, std::uint32_t settings = 0) {
    for (int i = 0; i < frames; ++i) {
      now_ += period;
      ++number_;
      if (i % 10 == 0) {
        say(period / std::chrono::nanoseconds(1));
      }
      reassembler_.push(test::datagrams(made(settings)).front(), now_);
      if (const std::optional<Frame> frame = reassembler_.take(now_)) {
        watch_.delivered(*frame);
      }
      watch_.look(reassembler_, now_);
    }
  }
  void say(std::int64_t period_ns, std::int32_t fx = 65536, std::uint32_t fingerprint = 77) {
    FrameSpec frame = made();
    frame.calibration = fingerprint;
    reassembler_.push(test::calibration_datagram(frame, period_ns, fx), now_);
    watch_.look(reassembler_, now_);
  }
  // How long after the newest frame silence is told; nothing: not within an hour.
  std::optional<Duration> told_after() {
    for (Duration after{0}; after < std::chrono::hours(1); after += milliseconds(1)) {
      if (watch_.state(now_ + after).silent) {
        return after;
      }
    }
    return std::nullopt;
  }

  LinkWatch watch_{kStart};
};

constexpr std::array<std::int64_t, 6> kLies{
    std::numeric_limits<std::int64_t>::max(), 60'000'000'001, 60'000'000'000, 1'000'000'000, 0,
    std::numeric_limits<std::int64_t>::min()};

TEST_F(ForgedPeriod, PutsOffNoAlarmForSilence) {
  for (const std::int64_t lie : kLies) {
    stream(20, kPeriod);
    ASSERT_LE(told_after(), 3 * kPeriod + milliseconds(21)) << lie;
    say(lie);
    EXPECT_LE(told_after(), 3 * (kPeriod + kPeriod / 8) + milliseconds(21)) << lie;
  }
}

TEST_F(ForgedPeriod, OfAStartThatNeverWasPutsOffNone) {
  stream(20, kPeriod);
  FrameSpec frame = made();
  frame.origin.session_id += 1;
  reassembler_.push(test::calibration_datagram(frame, kLies[2]), now_);
  watch_.look(reassembler_, now_);
  EXPECT_LE(told_after(), 3 * (kPeriod + kPeriod / 8) + milliseconds(21));
}

TEST_F(ForgedPeriod, BeforeTheSecondFrameIsASecondAtMost) {
  stream(1, kPeriod);
  say(60'000'000'000);
  EXPECT_LE(told_after(), milliseconds(3021));
}

TEST_F(ForgedPeriod, ThatNoSensorTakesIsTold) {
  stream(20, kPeriod);
  ASSERT_FALSE(watch_.state(now_).forged_traffic);
  say(60'000'000'001);
  EXPECT_TRUE(watch_.state(now_).forged_traffic);
  EXPECT_EQ(reassembler_.calibration()->period_ns, kPeriod / std::chrono::nanoseconds(1));
}

TEST_F(ForgedPeriod, OneThatWasSetAndSetBackIsNoForgery) {
  stream(20, kPeriod, 1);
  stream(1, 3 * kPeriod, 2);
  stream(20, kPeriod, 3);
  EXPECT_FALSE(watch_.state(now_).forged_traffic);
}

TEST_F(ForgedPeriod, ASlowerOneCountsOnceFramesComeSo) {
  stream(20, kPeriod, 1);
  stream(2, seconds(10), 2);
  const std::optional<Duration> told = told_after();
  EXPECT_GE(told, seconds(30));
  EXPECT_LE(told, seconds(30) + milliseconds(21));
  stream(40, kPeriod, 3);
  EXPECT_LE(told_after(), 3 * kPeriod + milliseconds(21));
}

// A frame that is far ahead makes a gap: the sensor's are refused for a second.
TEST_F(ForgedPeriod, AfterAGapThatAForgedFrameMadePutsOffNoAlarm) {
  for (const std::uint32_t ahead : {3U, 20U, 110U, 128U}) {
    stream(40, kPeriod);
    say(60'000'000'000);
    const std::uint32_t number = number_;
    number_ += ahead;
    reassembler_.push(test::datagrams(made()).front(), now_);
    static_cast<void>(reassembler_.take(now_));
    number_ = number;
    for (int k = 0; k < 45; ++k) {
      say(60'000'000'000);
      stream(1, kPeriod);
      say(60'000'000'000);
      EXPECT_LE(told_after(), seconds(1) + milliseconds(320)) << ahead;  // of the last frame
    }
    EXPECT_LE(told_after(), 3 * (kPeriod + kPeriod / 8) + milliseconds(21)) << ahead;
  }
}

TEST_F(ForgedPeriod, AfterGapsOfTheSensorsOwnPutsOffNoAlarm) {
  for (const milliseconds gap :
       {milliseconds(60), milliseconds(500), milliseconds(2000), milliseconds(3000)}) {
    stream(40, kPeriod);
    now_ += gap;
    number_ += static_cast<std::uint32_t>(gap / kPeriod);
    for (int k = 0; k < 40; ++k) {
      stream(1, kPeriod);
      say(60'000'000'000);
      EXPECT_LE(told_after(), 3 * (kPeriod + kPeriod / 8) + milliseconds(21)) << gap;
    }
  }
}

TEST_F(ForgedPeriod, FarBelowTheSensorsMakesNoFalseAlarm) {
  stream(40, kPeriod);
  for (const std::int64_t lie : {1, 1'000'000, 10'000'000}) {
    say(lie);
    EXPECT_GE(told_after(), 2 * kPeriod) << lie;
  }
}

TEST_F(ForgedPeriod, AFrameFarAheadThatTakesTheSensorsForASecondIsTold) {
  for (const bool fresh_alone : {false, true}) {
    stream(40, kPeriod);
    now_ += seconds(3);
    number_ += 90;
    stream(10, kPeriod);
    ASSERT_FALSE(watch_.state(now_).forged_traffic);
    FrameSpec ahead = spec(number_ + (fresh_alone ? 1 : 120), number_ + 120);
    ++number_;
    reassembler_.push(test::datagrams(ahead).front(), now_);
    stream(45, kPeriod);
    EXPECT_TRUE(watch_.state(now_).forged_traffic) << fresh_alone;
  }
}

TEST_F(ForgedPeriod, MakesNoOldFrameNew) {
  stream(20, kPeriod);
  say(60'000'000'000);
  ++number_;
  reassembler_.push(test::datagrams(made()).front(), now_);
  EXPECT_FALSE(reassembler_.take(now_ + milliseconds(200)));
}

TEST_F(Forged, GoodHealthIsNotEternal) {
  health(5000, 7);
  for (const std::uint64_t forged : {std::numeric_limits<std::uint64_t>::max(),
                                     std::uint64_t{1} << 62, std::uint64_t{5000 + 2001}}) {
    health(forged, 0);
    EXPECT_EQ(reassembler_.health()->active, 7U) << forged;
  }
  EXPECT_EQ(reassembler_.statistics().implausible, 3U);
  now_ += seconds(1);
  health(6000, 5);
  EXPECT_EQ(reassembler_.health()->active, 5U);
}

TEST_F(Forged, AFirstHealthThatLiesIsReplacedWithinThreeSeconds) {
  health(std::numeric_limits<std::uint64_t>::max(), 0);
  for (int second = 1; second <= 3; ++second) {
    now_ += seconds(1);
    health(5000 + 1000 * static_cast<std::uint64_t>(second), 7);
  }
  EXPECT_EQ(reassembler_.health()->active, 7U);
}

TEST_F(Forged, AnEventFarAheadSilencesNone) {
  EXPECT_TRUE(event(10));
  EXPECT_FALSE(event(10 + (1U << 30)));
  EXPECT_TRUE(event(11));
  EXPECT_EQ(reassembler_.statistics().implausible, 1U);
}

TEST_F(Forged, AnEventThatContradictsAnotherOneHidesNoneAndIsTold) {
  EXPECT_TRUE(event(10, 0));
  EXPECT_EQ(reassembler_.forgeries(), 0U);
  EXPECT_TRUE(event(10, 1));
  EXPECT_EQ(reassembler_.forgeries(), 1U);
  EXPECT_FALSE(event(10, 1));
  EXPECT_EQ(reassembler_.forgeries(), 1U);
}

TEST_F(Forged, AnEventThatTheSensorsHealthDoesNotKnowIsTold) {
  health(1000, 1, 10);
  EXPECT_TRUE(event(10, 1));
  EXPECT_TRUE(event(11, 0));  // it is over, somebody says
  EXPECT_EQ(reassembler_.forgeries(), 0U);
  now_ += seconds(1);
  health(2000, 1, 10);
  EXPECT_EQ(reassembler_.forgeries(), 1U);
}

TEST_F(Forged, AFirstEventThatLiesSilencesNoneThatIsRepeated) {
  EXPECT_TRUE(event(1U << 30));
  EXPECT_FALSE(event(11));
  now_ += seconds(1);
  EXPECT_TRUE(event(11));
  EXPECT_TRUE(event(12));
}

// Any stream of packets whose headers lie at random, beside a sensor's own: its frames come.
TEST_F(Forged, OfAStreamWithLiesInBetweenTheFramesCome) {
  test::Random random(5);
  int came = 0;
  for (int i = 0; i < 2000; ++i) {
    came += send(1);
    static_cast<void>(push(spec(static_cast<std::uint32_t>(random.next()),
                                static_cast<std::uint32_t>(random.next()))));
  }
  EXPECT_GE(came, 1900);
}

}  // namespace
}  // namespace stof::client
