#include <chrono>
#include <optional>
#include <vector>

#include <gtest/gtest.h>

#include "firmware/wire/bytes.h"
#include "host/client/reassembler.h"
#include "host/client/session/session_tracker.h"
#include "tests/host/client/sent_frame.h"

namespace stof::client {
namespace {

using std::chrono::milliseconds;
using test::calibration_datagram;
using test::Datagram;
using test::datagrams;
using test::ExpectedImages;
using test::frame_spec;
using test::FrameSpec;
using test::reseal;

constexpr Time kStart{};

std::size_t push_all(Reassembler& reassembler, const std::vector<Datagram>& packets,
                     Time now = kStart) {
  std::size_t frames = 0;
  for (const Datagram& packet : packets) {
    reassembler.push(packet, now);
    while (reassembler.take()) {
      ++frames;
    }
  }
  return frames;
}

FrameSpec in_session(std::uint32_t session, std::uint32_t number) {
  FrameSpec spec = frame_spec(number);
  spec.origin.session_id = session;
  spec.seed = (std::uint64_t{session} << 32) + number;
  return spec;
}

// The sensor answers a request in this session.
void told(Reassembler& reassembler, std::uint32_t session) {
  reassembler.expect(in_session(session, 1).origin);
}

TEST(Session, ARestartDropsWhatIsOpenAndBeginsAnew) {
  Reassembler reassembler;
  EXPECT_EQ(push_all(reassembler, datagrams(in_session(1, 1000))), 1U);
  std::vector<Datagram> half = datagrams(in_session(1, 1001));
  half.pop_back();
  EXPECT_EQ(push_all(reassembler, half), 0U);
  told(reassembler, 2);
  // The number of the frame that was open, in the new session: not one row of the old one.
  std::vector<Datagram> next = datagrams(in_session(2, 1001));
  next.erase(next.begin() + 3);
  EXPECT_EQ(push_all(reassembler, next), 0U);
  reassembler.expire(kStart + milliseconds(100));
  const std::optional<Frame> frame = reassembler.take();
  ASSERT_TRUE(frame);
  EXPECT_EQ(frame->origin.session_id, 2U);
  EXPECT_TRUE(ExpectedImages(next, 300, 5).equal(*frame));
  EXPECT_EQ(reassembler.statistics().frames_dropped, 1U);
  EXPECT_EQ(reassembler.statistics().sessions, 2U);
  EXPECT_EQ(reassembler.statistics().frames_lost, 0U);
}

TEST(Session, NumbersAndFreshnessStartAgain) {
  Reassembler reassembler;
  EXPECT_EQ(push_all(reassembler, datagrams(in_session(1, 1000))), 1U);
  told(reassembler, 2);
  EXPECT_EQ(push_all(reassembler, datagrams(in_session(2, 1))), 1U);
  EXPECT_EQ(push_all(reassembler, datagrams(in_session(2, 2))), 1U);
}

TEST(Session, PacketsOfAnEndedSessionAreForeign) {
  Reassembler reassembler;
  push_all(reassembler, datagrams(in_session(1, 1000)));
  told(reassembler, 2);
  push_all(reassembler, datagrams(in_session(2, 1)));
  told(reassembler, 3);
  push_all(reassembler, datagrams(in_session(3, 1)));
  EXPECT_EQ(push_all(reassembler, datagrams(in_session(1, 1001))), 0U);
  EXPECT_EQ(push_all(reassembler, datagrams(in_session(2, 2))), 0U);
  EXPECT_EQ(reassembler.statistics().foreign, 26U);
  EXPECT_EQ(reassembler.statistics().sessions, 3U);
  EXPECT_EQ(push_all(reassembler, datagrams(in_session(3, 2))), 1U);
  EXPECT_EQ(reassembler.forgeries(), 0U);
  const Time later = kStart + 2 * kTurnedRound;
  EXPECT_EQ(push_all(reassembler, datagrams(in_session(3, 3)), later), 1U);
  EXPECT_EQ(reassembler.forgeries(), 1U);  // of session 1, which had not ended just before
}

// What a sensor had sent before it started again comes late.
TEST(Session, LatePacketsOfTheOneBeforeAreNoForgery) {
  Reassembler reassembler;
  push_all(reassembler, datagrams(in_session(1, 1000)));
  told(reassembler, 2);
  push_all(reassembler, datagrams(in_session(2, 1)));
  EXPECT_EQ(push_all(reassembler, datagrams(in_session(1, 1001))), 0U);
  EXPECT_EQ(push_all(reassembler, datagrams(in_session(2, 2))), 1U);
  EXPECT_EQ(reassembler.forgeries(), 0U);
}

// Anybody can make sessions up.
TEST(Session, AnotherOneIsForgedWhileTheSensorGoesOn) {
  Reassembler reassembler;
  std::uint32_t number = 1;
  for (int ms = 0; ms < 5000; ms += 100, ++number) {
    const Time now = kStart + milliseconds(ms);
    EXPECT_EQ(push_all(reassembler, datagrams(in_session(100 + number, 7)), now),
              ms == 0 ? 1U : 0U);
    EXPECT_EQ(push_all(reassembler, datagrams(in_session(101, number + 7)), now), 1U);
  }
  EXPECT_EQ(reassembler.statistics().sessions, 1U);
  EXPECT_EQ(reassembler.forgeries(), 8U);  // one in 600 ms
}

// Nobody is asked, and the sensor starts again at once on a network that spreads packets.
TEST(Session, TheOneBeforeMayGoOnBesideTheNextForAWhile) {
  Reassembler reassembler;
  std::uint32_t number = 1;
  for (int ms = 0; ms < 480; ms += 20, ++number) {
    const Time now = kStart + milliseconds(ms);
    EXPECT_EQ(push_all(reassembler, datagrams(in_session(1, number)), now), 1U);
    EXPECT_EQ(push_all(reassembler, datagrams(in_session(2, number)), now), 0U);
  }
  for (int ms = 480; ms < 3000; ms += 20, ++number) {
    push_all(reassembler, datagrams(in_session(2, number)), kStart + milliseconds(ms));
  }
  EXPECT_EQ(reassembler.origin()->session_id, 2U);
  EXPECT_EQ(reassembler.forgeries(), 0U);
}

// Where nobody is asked, as on a serial line or with stofd --to.
TEST(Session, AnotherOneBeginsWhenTheOneBeforeIsSilent) {
  Reassembler reassembler;
  push_all(reassembler, datagrams(in_session(1, 1)));
  const Time silent = kStart + SessionTracker::kSilence;
  EXPECT_EQ(push_all(reassembler, datagrams(in_session(99, 7)), silent - milliseconds(1)), 0U);
  EXPECT_EQ(push_all(reassembler, datagrams(in_session(99, 8)), silent), 1U);
  EXPECT_EQ(push_all(reassembler, datagrams(in_session(1, 2)), silent + milliseconds(1)), 0U);
  EXPECT_EQ(push_all(reassembler, datagrams(in_session(1, 3)), silent + SessionTracker::kSilence),
            1U);
  EXPECT_EQ(reassembler.statistics().sessions, 3U);
  EXPECT_EQ(reassembler.forgeries(), 0U);
}

TEST(Session, NoOtherThanTheToldIsBelievedHoweverLongItIsSilent) {
  Reassembler reassembler;
  told(reassembler, 1);
  EXPECT_EQ(push_all(reassembler, datagrams(in_session(2, 1))), 0U);
  EXPECT_EQ(push_all(reassembler, datagrams(in_session(1, 1))), 1U);
  const Time later = kStart + std::chrono::hours(1);
  EXPECT_EQ(push_all(reassembler, datagrams(in_session(2, 2)), later), 0U);
  EXPECT_EQ(push_all(reassembler, datagrams(in_session(1, 2)), later), 1U);
  EXPECT_EQ(reassembler.statistics().sessions, 1U);
}

TEST(Session, CalibrationIsOfItsSession) {
  Reassembler reassembler;
  push_all(reassembler, {calibration_datagram(in_session(1, 1), 1, 1111)});
  ASSERT_TRUE(reassembler.calibration());
  EXPECT_EQ(reassembler.calibration()->fx, 1111);
  for (const Datagram& packet : datagrams(in_session(1, 1))) {
    reassembler.push(packet, kStart);
  }
  EXPECT_EQ(reassembler.take()->calibration->fx, 1111);
  told(reassembler, 2);
  for (const Datagram& packet : datagrams(in_session(2, 1))) {
    reassembler.push(packet, kStart);
  }
  EXPECT_FALSE(reassembler.take()->calibration);
  EXPECT_FALSE(reassembler.calibration());
}

// Of a sensor that gets another one while it runs; messages and frames may overtake each other.
TEST(Session, AFrameHasTheCalibrationThatItWasMadeWithOrNone) {
  Reassembler reassembler;
  const auto made_with = [](std::uint32_t number, std::uint32_t calibration) {
    FrameSpec spec = frame_spec(number);
    spec.calibration = calibration;
    return spec;
  };
  const auto calibration_of = [&](std::uint32_t number, std::uint32_t calibration) {
    for (const Datagram& packet : datagrams(made_with(number, calibration))) {
      reassembler.push(packet, kStart);
    }
    const std::optional<Frame> frame = reassembler.take();
    return frame && frame->calibration ? frame->calibration->fx : 0;
  };
  push_all(reassembler, {calibration_datagram(made_with(1, 0xA), 1, 1111)});
  EXPECT_EQ(calibration_of(1, 0xA), 1111);
  EXPECT_EQ(calibration_of(2, 0xB), 0);  // the message of the new one was lost
  push_all(reassembler, {calibration_datagram(made_with(5, 0xB), 1, 2222)});
  EXPECT_EQ(calibration_of(4, 0xA), 1111);  // overtaken by the message of the new one
  EXPECT_EQ(calibration_of(5, 0xB), 2222);
  EXPECT_EQ(calibration_of(6, 0), 2222);  // of a sensor that does not tell
}

TEST(Session, AnOlderCalibrationDoesNotReplaceANewer) {
  Reassembler reassembler;
  push_all(reassembler, {calibration_datagram(frame_spec(10), 1, 1010),
                         calibration_datagram(frame_spec(9), 1, 999)});
  EXPECT_EQ(reassembler.calibration()->fx, 1010);
  EXPECT_EQ(reassembler.statistics().late, 1U);
  push_all(reassembler, {calibration_datagram(frame_spec(11), 1, 1111)});
  EXPECT_EQ(reassembler.calibration()->fx, 1111);
}

TEST(Device, OnlyTheFirstHeardIsListenedTo) {
  Reassembler reassembler;
  FrameSpec other = frame_spec(1);
  other.origin.device_id = 5;
  EXPECT_EQ(push_all(reassembler, datagrams(frame_spec(1))), 1U);
  EXPECT_EQ(push_all(reassembler, datagrams(other)), 0U);
  EXPECT_EQ(reassembler.statistics().foreign, 13U);
}

TEST(Device, OnlyTheNamedIsListenedTo) {
  Reassembler reassembler({.device_id = 5});
  FrameSpec named = frame_spec(1);
  named.origin.device_id = 5;
  EXPECT_EQ(push_all(reassembler, datagrams(frame_spec(1))), 0U);
  EXPECT_EQ(push_all(reassembler, datagrams(named)), 1U);
  EXPECT_EQ(reassembler.statistics().foreign, 13U);
}

TEST(Newer, UnknownPartsAreCountedAndTheFrameIsWhole) {
  struct Change {
    std::size_t offset;
    std::byte value;
  };
  // A type, a stream and a codec without a name, and a pair that does not belong together.
  for (const Change& change : {Change{5, std::byte{9}}, Change{16, std::byte{77}},
                               Change{17, std::byte{99}}, Change{17, std::byte{2}}}) {
    std::vector<Datagram> packets = datagrams(frame_spec(1));
    packets[1][change.offset] = change.value;
    reseal(packets[1]);
    Reassembler reassembler;
    EXPECT_EQ(push_all(reassembler, packets), 1U) << change.offset;
    EXPECT_EQ(reassembler.statistics().unknown, 1U);
    EXPECT_EQ(reassembler.statistics().packets_ok, 12U);
    EXPECT_EQ(reassembler.statistics().frames_complete, 1U);
  }
}

TEST(Newer, UnknownPacketsOutsideFramesAreCounted) {
  Datagram packet = calibration_datagram(frame_spec(1), 1);
  Reassembler reassembler;
  // Of nobody yet; sectors and an announcement, which say nothing to a receiver of frames.
  for (const std::uint8_t type : {std::uint8_t{127}, std::uint8_t{69}, std::uint8_t{68}}) {
    packet[5] = std::byte{type};
    reseal(packet);
    EXPECT_EQ(push_all(reassembler, {packet}), 0U);
  }
  EXPECT_EQ(reassembler.statistics().unknown, 3U);
  EXPECT_FALSE(reassembler.next_expiry());  // no frame was begun
}

TEST(Hostile, AnImmenseImageIsRefusedBeforeAnythingIsAllocated) {
  Datagram huge = datagrams(frame_spec(1)).front();
  wire::put_u16(std::span(huge).subspan<40, 2>(), 65535);
  wire::put_u16(std::span(huge).subspan<42, 2>(), 65535);
  reseal(huge);
  Reassembler reassembler;
  EXPECT_EQ(push_all(reassembler, {huge}), 0U);
  EXPECT_EQ(reassembler.statistics().oversized, 1U);
  EXPECT_FALSE(reassembler.next_expiry());
}

TEST(Hostile, AShortFrameInfoOrCalibrationIsRefused) {
  for (const std::uint8_t type : {std::uint8_t{2}, std::uint8_t{64}}) {
    Datagram tile = datagrams(frame_spec(1)).back();
    tile.erase(tile.begin() + 52, tile.end() - 4);
    wire::put_u16(std::span(tile).subspan<50, 2>(), 0);
    tile[5] = std::byte{type};
    reseal(tile);
    Reassembler reassembler;
    push_all(reassembler, {tile});
    EXPECT_EQ(reassembler.statistics().bad_field, 1U);
    EXPECT_FALSE(reassembler.next_expiry());
  }
}

// The CRC is right, the fields are anything: no crash, and every datagram is counted once.
TEST(Hostile, RandomFieldsAreCountedOnceAndHarmless) {
  test::Random random(11);
  const std::vector<Datagram> frame = datagrams(frame_spec(1));
  Reassembler reassembler({.max_pixels = 20'000});
  std::uint64_t pushed = 0;
  std::uint64_t taken = 0;
  for (int round = 0; round < 100'000; ++round) {
    Datagram packet = frame[static_cast<std::size_t>(random.between(0, 12))];
    for (const std::size_t counter : {std::size_t{20}, std::size_t{32}}) {  // number, freshness
      wire::put_u32(std::span(packet).subspan(counter).first<4>(),
                    1 + static_cast<std::uint32_t>(round) / 20);
    }
    const int changes = random.between(0, 3);
    for (int i = 0; i < changes; ++i) {
      const auto at = static_cast<std::size_t>(random.between(16, 55));
      packet[at] = random.between(0, 1) == 0 ? static_cast<std::byte>(random.between(0, 4))
                                             : static_cast<std::byte>(random.next());
    }
    if (random.between(0, 9) != 0) {
      reseal(packet);
    }
    reassembler.push(packet, kStart + milliseconds(round));
    ++pushed;
    if (random.between(0, 3) == 0) {
      reassembler.expire(kStart + milliseconds(round));
    }
    while (reassembler.take()) {
      ++taken;
    }
  }
  const Statistics& statistics = reassembler.statistics();
  EXPECT_EQ(statistics.packets(), pushed);
  EXPECT_EQ(statistics.frames_complete + statistics.frames_incomplete, taken);
  EXPECT_GT(statistics.packets_ok, 1000U);
  EXPECT_GT(statistics.bad_field, 1000U);
  EXPECT_GT(statistics.bad_crc, 1000U);
}

TEST(Hostile, EveryRefusalHasItsOwnCounter) {
  const Datagram good = datagrams(frame_spec(1)).front();
  Datagram magic = good;
  magic[0] = std::byte{'X'};
  Datagram version = good;
  version[4] = std::byte{2};
  Datagram length = good;
  length.push_back(std::byte{0});
  Datagram crc = good;
  crc[70] ^= std::byte{1};
  Datagram field = good;
  wire::put_u16(std::span(field).subspan<36, 2>(), 13);
  reseal(field);
  Reassembler reassembler;
  push_all(reassembler, {Datagram(55), magic, version, length, crc, field});
  Statistics expected;
  expected.truncated = expected.bad_magic = expected.bad_version = 1;
  expected.bad_length = expected.bad_crc = expected.bad_field = 1;
  EXPECT_EQ(reassembler.statistics(), expected);
}

}  // namespace
}  // namespace stof::client
