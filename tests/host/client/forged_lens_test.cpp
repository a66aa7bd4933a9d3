// Calibrations that a stranger sends in a sensor's name: with another lens under its fingerprint,
// or with another fingerprint. No frame has a lens that its sensor did not tell, but within the
// first second.
#include <array>
#include <chrono>
#include <cstdint>
#include <optional>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

#include "firmware/wire/messages/calibration.h"
#include "host/client/reassembler.h"
#include "host/client/session/link_watch.h"
#include "host/client/session/session_tracker.h"
#include "tests/host/client/sent_frame.h"

namespace stof::client {
namespace {

using std::chrono::milliseconds;
using std::chrono::seconds;
using test::FrameSpec;

constexpr std::int32_t kTrue = 111;
constexpr std::int32_t kForged = 444;
constexpr std::uint32_t kFile = 77;  // the fingerprint
constexpr milliseconds kPeriod(100);

struct Lenses {
  int of_sensor = 0;
  int forged = 0;
  int none = 0;
};

// A sensor that sends a frame each period and its calibration once a second, at the start of each.
class ForgedLens : public testing::Test {
 protected:
  FrameSpec frame() const {
    return {.number = number_,
            .freshness = number_,
            .origin = origin_,
            .width = 20,
            .height = 5,
            .calibration = file_,
            .period_ns = kPeriod / std::chrono::nanoseconds(1)};
  }
  void say(std::int32_t fx, std::uint32_t file, std::uint32_t unit_um = 250, int width = 20) {
    const FrameSpec beside = frame();
    std::array<std::byte, wire::kCalibrationPacketBytes> payload{};
    wire::encode_calibration_packet({.image_width = static_cast<std::uint16_t>(width),
                                     .image_height = 5,
                                     .fx = fx,
                                     .fy = 65536,
                                     .depth_unit_um = unit_um,
                                     .period_ns = kPeriod / std::chrono::nanoseconds(1),
                                     .fingerprint = file},
                                    payload);
    reassembler_.push(test::report_datagram(beside, wire::PacketType::kCalibration, payload), now_);
    watch_.look(reassembler_, now_);
  }
  // For so many frames; lie(k) is called 50 ms after frame k of them.
  template <typename Lie>
  Lenses stream(int frames, Lie lie) {
    Lenses came;
    for (int k = 0; k < frames; ++k) {
      now_ += kPeriod / 2;
      ++number_;
      if (number_ % 10 == 0) {
        say(lens_, file_);
      }
      for (const test::Datagram& packet : test::datagrams(frame())) {
        reassembler_.push(packet, now_);
      }
      while (const std::optional<Frame> taken = reassembler_.take(now_)) {
        const std::int32_t fx = taken->calibration ? taken->calibration->fx : 0;
        ++(fx == 0 ? came.none : fx == lens_ ? came.of_sensor : came.forged);
      }
      now_ += kPeriod / 2;
      lie(k);
      watch_.look(reassembler_, now_);
    }
    return came;
  }
  Lenses stream(int frames) {
    return stream(frames, [](int) {});
  }
  bool told() const { return watch_.state(now_).forged_traffic; }

  Reassembler reassembler_;
  Time now_{seconds(100)};
  LinkWatch watch_{now_};
  wire::Origin origin_ = test::kOrigin;
  std::uint32_t number_ = 999;
  std::uint32_t file_ = kFile;
  std::int32_t lens_ = kTrue;
};

TEST_F(ForgedLens, ThatTheSensorNeverToldIsNotBelievedAtAnyRate) {
  stream(150);
  for (const int every : {1, 4, 5, 7, 10}) {
    const Lenses came = stream(200, [&](int k) {
      if (k % every == 0) {
        say(kForged, kFile);
      }
    });
    EXPECT_EQ(came.of_sensor, 200) << every;
    EXPECT_TRUE(told()) << every;
  }
}

// As was found: one short after the sensor's own, one more than half a second later, and so on.
TEST_F(ForgedLens, TwiceBetweenTwoOfTheSensorsIsNotBelieved) {
  stream(150);
  const Lenses came = stream(200, [&](int) {
    if (number_ % 10 == 1 || number_ % 10 == 7) {
      say(kForged, kFile);
    }
  });
  EXPECT_EQ(came.of_sensor, 200);
  EXPECT_TRUE(told());
}

TEST_F(ForgedLens, AfterFourSecondsOfTheSensorsOwnIsNotBelieved) {
  stream(45);
  EXPECT_EQ(stream(200, [&](int) { say(kForged, kFile); }).of_sensor, 200);
}

TEST_F(ForgedLens, OfOtherNumbersEachTimeIsNotBelieved) {
  stream(150);
  const Lenses came = stream(200, [&](int k) { say(kForged + k, kFile); });
  EXPECT_EQ(came.of_sensor, 200);
  EXPECT_TRUE(told());
}

TEST_F(ForgedLens, WithAnotherUnitOrSizeIsNotBelieved) {
  stream(150);
  const Lenses came = stream(200, [&](int k) {
    say(kTrue, kFile, 1000);
    say(kForged, kFile, 250, k % 2 == 0 ? 40 : 0);
  });
  EXPECT_EQ(came.of_sensor, 200);
  EXPECT_TRUE(told());
}

// That frames name their calibration, and go with no other one, is what a stranger may count on.
TEST_F(ForgedLens, WithAnotherFingerprintTakesNoFrameItsLens) {
  stream(150);
  for (const int every : {1, 5}) {
    const Lenses came = stream(200, [&](int k) {
      if (k % every == 0) {
        say(kForged, 99);
        say(kForged, static_cast<std::uint32_t>(1000 + k));
      }
    });
    EXPECT_EQ(came.of_sensor, 200) << every;
    EXPECT_TRUE(told()) << every;
    EXPECT_EQ(reassembler_.calibration()->fx, kTrue);
  }
}

TEST_F(ForgedLens, WithAnotherFingerprintFromTheStartTakesNoFrameItsLensAndIsTold) {
  say(kForged, 99);
  stream(10);
  const Lenses came = stream(100, [&](int k) {
    if (k % 5 == 0) {
      say(kForged, 99);
    }
  });
  EXPECT_EQ(came.of_sensor, 100);
  EXPECT_TRUE(told());
}

// Nobody can say which one lies: none is believed.
TEST_F(ForgedLens, FromTheStartLeavesNoLensAndIsTold) {
  say(kForged, kFile);
  const Lenses first = stream(10);
  EXPECT_LE(first.forged, 10);
  for (const int every : {1, 4, 10, 20}) {
    const Lenses came = stream(200, [&](int k) {
      if (k % every == 0) {
        say(kForged, kFile);
      }
    });
    EXPECT_EQ(came.forged, 0) << every;
    EXPECT_TRUE(told()) << every;
  }
  stream(45);
  EXPECT_EQ(stream(100).of_sensor, 100) << "alone again";
}

TEST_F(ForgedLens, OfAFirstMessageIsGoneAfterASecondAndTheTrueOneThereAfterFour) {
  say(kForged, kFile);
  const Lenses first = stream(10);
  EXPECT_LE(first.forged, 10);
  EXPECT_TRUE(told());
  EXPECT_EQ(stream(100).forged, 0);
  EXPECT_EQ(stream(100).of_sensor, 100);
}

TEST_F(ForgedLens, SaidOfACalibrationThatComesNextIsNotBelieved) {
  stream(150, [&](int) { say(kForged, 78); });
  file_ = 78;
  say(lens_, file_);
  EXPECT_EQ(stream(200, [&](int) { say(kForged, 78); }).forged, 0);
}

TEST_F(ForgedLens, AfterAStartThatNeverWasIsNotBelieved) {
  stream(150);
  for (int start = 0; start < 5; ++start) {
    origin_.session_id += 1;
    say(kForged, kFile);
    origin_.session_id -= 1;
    const Lenses came = stream(30, [&](int) { say(kForged, kFile); });
    EXPECT_EQ(came.forged, 0);
    EXPECT_GE(came.of_sensor, 1);
  }
}

TEST_F(ForgedLens, OfAStandingOneIsNotBelievedHoweverManyOtherSizesAreTold) {
  stream(150);
  for (const int sizes : {8, 32, 200}) {
    const Lenses came = stream(100, [&](int) {
      for (int i = 0; i < sizes; ++i) {
        say(kForged, kFile, 250, 100 + i);
      }
      say(kForged, kFile);
    });
    EXPECT_EQ(came.forged, 0);
    EXPECT_EQ(came.of_sensor, 100);
  }
  EXPECT_TRUE(told());
}

// Nobody answered in it.
TEST_F(ForgedLens, OfAnotherSessionIsNotBelievedHoweverLongItGoesOn) {
  reassembler_.expect(origin_);
  stream(150);
  const std::uint32_t session = origin_.session_id;
  const std::uint32_t number = number_;
  origin_.session_id = 99;
  const Lenses his = stream(300, [&](int) { say(kForged, kFile); });
  EXPECT_EQ(his.forged + his.of_sensor + his.none, 0);
  origin_.session_id = session;
  number_ = number;
  const Lenses came = stream(100, [&](int) { say(kForged, kFile); });
  EXPECT_EQ(came.forged, 0);
  EXPECT_GE(came.of_sensor, 90);
}

// As while the sensor is off.
TEST_F(ForgedLens, OfAStrangerBeforeTheFirstAnswerEndsWithIt) {
  const wire::Origin sensor = std::exchange(origin_, {.device_id = 5, .session_id = 99});
  lens_ = kForged;
  stream(260);
  lens_ = kTrue;
  origin_ = sensor;
  reassembler_.expect(sensor);
  const Lenses came = stream(100, [&](int k) {
    if (k % 40 == 0) {
      say(kForged, kFile);
    }
  });
  EXPECT_EQ(came.forged, 0);
  stream(30);  // until the sensor's was alone for three seconds
  EXPECT_EQ(stream(100).of_sensor, 100);
}

// Where nobody is asked, whoever speaks first is believed as long as he goes on.
TEST_F(ForgedLens, OfAStrangerWhoWasThereBeforeTheSensorEndsWithHisSession) {
  lens_ = kForged;
  const std::uint32_t session = std::exchange(origin_.session_id, 99);
  stream(260);
  lens_ = kTrue;
  origin_.session_id = session;
  number_ = 1;
  now_ += SessionTracker::kSilence;
  const Lenses came = stream(100);
  EXPECT_EQ(came.forged, 0);
  EXPECT_GE(came.of_sensor, 90);
}

TEST_F(ForgedLens, BesideAFrameThatIsStillToComeMakesTheSensorsNotLate) {
  stream(150);
  const Lenses came = stream(300, [&](int) {
    number_ += 100;
    say(kForged, kFile);
    say(kForged, 99);
    number_ -= 100;
  });
  EXPECT_EQ(came.of_sensor, 300);
}

// The sensor's own does not come any more: what says something else for as long is believed.
TEST_F(ForgedLens, OneThatWasBelievedGivesWayToAnotherOnlyWhereItWasGoneForTenSeconds) {
  stream(150);
  lens_ = 222;
  EXPECT_EQ(stream(95).of_sensor, 0);
  stream(20);
  EXPECT_EQ(stream(100).of_sensor, 100);
}

TEST_F(ForgedLens, ACalibrationThatIsInstalledHoldsFromItsFirstFrameAndSoDoesTheFormer) {
  stream(150);
  for (int turn = 0; turn < 3; ++turn) {
    file_ = turn % 2 == 0 ? 78 : kFile;
    lens_ = turn % 2 == 0 ? 222 : kTrue;
    say(lens_, file_);
    EXPECT_EQ(stream(35).of_sensor, 35) << turn;
    EXPECT_FALSE(told()) << turn;
    EXPECT_EQ(reassembler_.calibration()->fx, lens_);
  }
}

// The last one of before comes behind the new one, and both before the frames of the new one.
TEST_F(ForgedLens, WhatTheNetworkTurnsRoundWhereTheSensorChangesIsNoForgery) {
  stream(150);
  file_ = 78;
  lens_ = 222;
  number_ += 2;
  say(lens_, file_);
  number_ -= 2;
  now_ += kPeriod;
  say(kTrue, kFile);
  EXPECT_EQ(stream(35).forged, 0);
  EXPECT_FALSE(told());
}

TEST_F(ForgedLens, ChangesWhoseFramesWereTooOldToBeReadAreNoForgery) {
  stream(150);
  for (const std::uint32_t file : {78U, 79U, 80U}) {
    file_ = file;
    say(lens_, file_);
    for (int k = 0; k < 5; ++k) {
      now_ += kPeriod;
      ++number_;
      for (const test::Datagram& packet : test::datagrams(frame())) {
        reassembler_.push(packet, now_, now_ + seconds(2));
      }
    }
  }
  EXPECT_EQ(reassembler_.statistics().frames_old, 15U);
  stream(35);
  EXPECT_FALSE(told());
}

TEST_F(ForgedLens, AFrameWithoutItsInfoHasTheLensOfTheFrameBefore) {
  stream(150);
  const auto without_info = [&] {
    ++number_;
    const std::vector<test::Datagram> packets = test::datagrams(frame());
    for (std::size_t k = 1; k < packets.size(); ++k) {
      reassembler_.push(packets[k], now_);
    }
    now_ += kPeriod;
    reassembler_.expire(now_ + kPeriod);
    const std::optional<Frame> taken = reassembler_.take();
    return taken && !taken->info && taken->calibration ? taken->calibration->fx : 0;
  };
  EXPECT_EQ(without_info(), kTrue);
  say(kForged, 99);
  EXPECT_EQ(without_info(), 0);
}

TEST(LensBookOnALine, ThePictureChangesItsUnit) {
  ReassemblerOptions options;
  options.serial_line = true;
  Reassembler reassembler(options);
  for (const std::uint32_t unit : {16000U, 4000U, 16000U}) {
    std::array<std::byte, wire::kCalibrationPacketBytes> payload{};
    wire::encode_calibration_packet({.image_width = 20,
                                     .image_height = 5,
                                     .fx = 1,
                                     .fy = 1,
                                     .depth_unit_um = unit,
                                     .fingerprint = kFile},
                                    payload);
    reassembler.push(
        test::report_datagram(test::frame_spec(1), wire::PacketType::kCalibration, payload),
        Time(seconds(1)));
    ASSERT_TRUE(reassembler.calibration());
    EXPECT_EQ(reassembler.calibration()->depth_unit_um, unit);
  }
  EXPECT_EQ(reassembler.statistics().implausible, 0U);
}

}  // namespace
}  // namespace stof::client
