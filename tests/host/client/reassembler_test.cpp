#include "host/client/reassembler.h"

#include <chrono>
#include <optional>
#include <vector>

#include <gtest/gtest.h>

#include "firmware/wire/bytes.h"
#include "tests/host/client/sent_frame.h"

namespace stof::client {
namespace {

using std::chrono::milliseconds;
using test::Datagram;
using test::datagrams;
using test::ExpectedImages;
using test::frame_spec;
using test::FrameSpec;
using test::reseal;

constexpr Time kStart{};

// What of a frame is worth knowing when its pixels are gone.
struct Seen {
  std::uint32_t number;
  std::uint32_t missing_packets;
};

std::vector<Seen> push_all(Reassembler& reassembler, const std::vector<Datagram>& packets,
                           Time now = kStart) {
  std::vector<Seen> seen;
  for (const Datagram& packet : packets) {
    reassembler.push(packet, now);
    while (const std::optional<Frame> frame = reassembler.take()) {
      seen.push_back({frame->stamp.number, frame->missing_packets});
    }
  }
  return seen;
}

std::vector<Datagram> without(std::vector<Datagram> packets, std::size_t index) {
  packets.erase(packets.begin() + static_cast<std::ptrdiff_t>(index));
  return packets;
}

TEST(Reassembler, AWholeFrameIsDeliveredAtItsLastPacket) {
  const std::vector<Datagram> packets = datagrams(frame_spec(100));
  ASSERT_EQ(packets.size(), 13U);
  Reassembler reassembler;
  for (std::size_t i = 0; i + 1 < packets.size(); ++i) {
    reassembler.push(packets[i], kStart);
    ASSERT_FALSE(reassembler.take());
  }
  reassembler.push(packets.back(), kStart + milliseconds(3));
  const std::optional<Frame> frame = reassembler.take();
  ASSERT_TRUE(frame);
  EXPECT_TRUE(frame->complete());
  EXPECT_TRUE(ExpectedImages(packets, 300, 5).equal(*frame));
  EXPECT_EQ(frame->origin.session_id, test::kOrigin.session_id);
  EXPECT_EQ(frame->stamp.number, 100U);
  EXPECT_EQ(frame->stamp.exposure_middle_ns, 100'000'000);
  EXPECT_EQ(frame->packets, 13U);
  EXPECT_EQ(frame->missing, decltype(frame->missing){});
  ASSERT_TRUE(frame->info);
  EXPECT_EQ(frame->info->tiles[0], 5);
  EXPECT_EQ(frame->last_packet - frame->first_packet, milliseconds(3));
  EXPECT_FALSE(reassembler.take());
  Statistics expected;
  expected.packets_ok = 13;
  expected.frames_complete = 1;
  expected.sessions = 1;
  EXPECT_EQ(reassembler.statistics(), expected);
}

// The memory of frame 100 is used again: its pixels must not show through.
TEST(Reassembler, WhatIsMissingIsNoneAndMarkedWhicheverPacketIsLost) {
  for (std::size_t lost = 0; lost < 13; ++lost) {
    Reassembler reassembler;
    for (std::uint32_t number = 100; number < 108; ++number) {
      ASSERT_EQ(push_all(reassembler, datagrams(frame_spec(number))).size(), 1U);
    }
    const std::vector<Datagram> rest = without(datagrams(frame_spec(108)), lost);
    ASSERT_TRUE(push_all(reassembler, rest).empty());
    reassembler.expire(kStart + std::chrono::seconds(1));
    const std::optional<Frame> frame = reassembler.take();
    ASSERT_TRUE(frame) << lost;
    const ExpectedImages expected(rest, 300, 5);
    EXPECT_TRUE(expected.equal(*frame)) << lost;
    EXPECT_EQ(frame->missing_packets, 1U);
    EXPECT_EQ(frame->missing_pixels(wire::Stream::kDepth), expected.missing(kHasDepth));
    EXPECT_EQ(frame->missing_pixels(wire::Stream::kWidth), expected.missing(kHasWidth));
    EXPECT_EQ(frame->missing_pixels(wire::Stream::kSource), expected.missing(kHasSource));
    EXPECT_EQ(frame->info.has_value(), lost != 0);
    EXPECT_EQ(reassembler.statistics().packets_missing, 1U);
    EXPECT_EQ(reassembler.statistics().frames_incomplete, 1U);
  }
}

TEST(Reassembler, TwoFramesInFlightMayBeMixed) {
  const std::vector<Datagram> first = datagrams(frame_spec(100));
  const std::vector<Datagram> second = datagrams(frame_spec(101));
  std::vector<Datagram> mixed;
  for (std::size_t i = 0; i < first.size(); ++i) {
    mixed.push_back(second[first.size() - 1 - i]);
    mixed.push_back(first[i]);
  }
  std::swap(mixed[mixed.size() - 1], mixed[mixed.size() - 2]);  // the first frame is whole first
  Reassembler reassembler;
  const std::vector<Seen> seen = push_all(reassembler, mixed);
  ASSERT_EQ(seen.size(), 2U);
  EXPECT_EQ(seen[0].number, 100U);
  EXPECT_EQ(seen[1].number, 101U);
  EXPECT_EQ(reassembler.statistics().frames_complete, 2U);
}

TEST(Reassembler, ALaterFrameThatIsWholeClosesTheOneBefore) {
  Reassembler reassembler;
  EXPECT_TRUE(push_all(reassembler, without(datagrams(frame_spec(100)), 4)).empty());
  const std::vector<Seen> seen = push_all(reassembler, datagrams(frame_spec(101)));
  ASSERT_EQ(seen.size(), 2U);
  EXPECT_EQ(seen[0].number, 100U);
  EXPECT_EQ(seen[0].missing_packets, 1U);
  EXPECT_EQ(seen[1].number, 101U);
  EXPECT_EQ(seen[1].missing_packets, 0U);
}

TEST(Reassembler, TheNextButOneFrameClosesAtItsFirstPacket) {
  Reassembler reassembler;
  EXPECT_TRUE(push_all(reassembler, without(datagrams(frame_spec(100)), 4)).empty());
  EXPECT_TRUE(push_all(reassembler, without(datagrams(frame_spec(101)), 4)).empty());
  const std::vector<Seen> seen = push_all(reassembler, {datagrams(frame_spec(102)).front()});
  ASSERT_EQ(seen.size(), 1U);
  EXPECT_EQ(seen[0].number, 100U);
}

TEST(Reassembler, AJumpAheadClosesBothInTheirOrder) {
  Reassembler reassembler;
  push_all(reassembler, {datagrams(frame_spec(101)).front(), datagrams(frame_spec(100)).front()});
  const FrameSpec far{.number = 200, .freshness = 200, .width = 0, .height = 0};  // one packet
  const std::vector<Seen> seen = push_all(reassembler, datagrams(far));
  ASSERT_EQ(seen.size(), 3U);
  EXPECT_EQ(seen[0].number, 100U);
  EXPECT_EQ(seen[1].number, 101U);
  EXPECT_EQ(seen[2].number, 200U);
  EXPECT_EQ(reassembler.statistics().frames_lost, 98U);
  EXPECT_EQ(reassembler.statistics().packets_missing, 24U);
}

TEST(Reassembler, AFrameWaitsForItsTimeoutAndNoLonger) {
  Reassembler reassembler;
  EXPECT_FALSE(reassembler.next_expiry());
  push_all(reassembler, {datagrams(frame_spec(100)).front()}, kStart);
  push_all(reassembler, {datagrams(frame_spec(100)).back()}, kStart + milliseconds(50));
  ASSERT_TRUE(reassembler.next_expiry());
  EXPECT_EQ(*reassembler.next_expiry(), kStart + milliseconds(150));
  reassembler.expire(*reassembler.next_expiry() - Duration(1));
  EXPECT_FALSE(reassembler.take());
  reassembler.expire(*reassembler.next_expiry());
  EXPECT_TRUE(reassembler.take());
  EXPECT_FALSE(reassembler.next_expiry());
}

TEST(Reassembler, TheTimeoutIsOneAndAHalfPeriodsOfASlowSensor) {
  Reassembler reassembler;
  const FrameSpec spec = frame_spec(100);
  push_all(reassembler, {test::calibration_datagram(spec, 200'000'000), datagrams(spec).front()});
  EXPECT_EQ(reassembler.next_expiry(), kStart + milliseconds(300));
  for (const std::int64_t absurd : {INT64_MIN, std::int64_t{-1}, INT64_MAX}) {
    push_all(reassembler, {test::calibration_datagram(spec, absurd)});
    EXPECT_GE(reassembler.next_expiry(), kStart + milliseconds(100)) << absurd;
    EXPECT_LE(reassembler.next_expiry(), kStart + std::chrono::seconds(10)) << absurd;
  }
}

TEST(Reassembler, WhenTheLaterFrameExpiresTheEarlierGoesFirst) {
  Reassembler reassembler;
  push_all(reassembler, {datagrams(frame_spec(101)).front()}, kStart);
  push_all(reassembler, {datagrams(frame_spec(100)).front()}, kStart + milliseconds(99));
  reassembler.expire(kStart + milliseconds(100));
  EXPECT_EQ(reassembler.take()->stamp.number, 100U);
  EXPECT_EQ(reassembler.take()->stamp.number, 101U);
}

TEST(Reassembler, DuplicatesAreCountedWhileAndAfterTheFrame) {
  Reassembler reassembler;
  const std::vector<Datagram> packets = datagrams(frame_spec(100));
  push_all(reassembler, {packets[0], packets[0], packets[3], packets[3], packets[3]});
  EXPECT_EQ(reassembler.statistics().duplicate, 3U);
  EXPECT_EQ(push_all(reassembler, packets).size(), 1U);
  EXPECT_EQ(reassembler.statistics().duplicate, 5U);
  push_all(reassembler, packets);
  EXPECT_EQ(reassembler.statistics().duplicate, 18U);
  EXPECT_EQ(reassembler.statistics().packets_ok, 13U);
  EXPECT_EQ(reassembler.statistics().frames_complete, 1U);
}

TEST(Reassembler, APacketAfterItsFrameIsLateNotNew) {
  Reassembler reassembler;
  const std::vector<Datagram> packets = datagrams(frame_spec(100));
  push_all(reassembler, without(packets, 4));
  EXPECT_EQ(push_all(reassembler, datagrams(frame_spec(101))).size(), 2U);
  EXPECT_TRUE(push_all(reassembler, {packets[4]}).empty());
  EXPECT_TRUE(push_all(reassembler, datagrams(frame_spec(99))).empty());
  EXPECT_EQ(reassembler.statistics().late, 14U);
  EXPECT_EQ(reassembler.statistics().duplicate, 0U);
}

TEST(Reassembler, SkippedNumbersAreLostFrames) {
  Reassembler reassembler;
  push_all(reassembler, datagrams(frame_spec(100)));
  push_all(reassembler, datagrams(frame_spec(104)));
  EXPECT_EQ(reassembler.statistics().frames_lost, 3U);
  EXPECT_EQ(reassembler.statistics().packets_missing, 0U);
}

TEST(Reassembler, NumbersAndFreshnessWrapWithoutAGap) {
  Reassembler reassembler;
  std::vector<Seen> seen;
  for (std::uint32_t i = 0; i < 8; ++i) {
    const std::vector<Seen> more = push_all(reassembler, datagrams(frame_spec(0xFFFFFFFC + i)));
    seen.insert(seen.end(), more.begin(), more.end());
  }
  EXPECT_EQ(seen.size(), 8U);
  EXPECT_EQ(reassembler.statistics().frames_complete, 8U);
  EXPECT_EQ(reassembler.statistics().frames_lost, 0U);
  EXPECT_EQ(reassembler.statistics().late, 0U);
}

TEST(Reassembler, AFrameWhoseFreshnessDidNotAdvanceIsNotDelivered) {
  Reassembler reassembler;
  FrameSpec spec{.number = 1, .freshness = 0};
  EXPECT_TRUE(push_all(reassembler, datagrams(spec)).empty());  // never a verified exposure
  spec = {.number = 2, .freshness = 5};
  EXPECT_EQ(push_all(reassembler, datagrams(spec)).size(), 1U);
  for (const std::uint32_t freshness : {5U, 4U, 0U, 0x80000005U}) {
    ++spec.number;
    spec.freshness = freshness;
    EXPECT_TRUE(push_all(reassembler, datagrams(spec)).empty()) << freshness;
  }
  spec = {.number = 7, .freshness = 6};
  EXPECT_EQ(push_all(reassembler, datagrams(spec)).size(), 1U);
  EXPECT_EQ(reassembler.statistics().frames_stale, 5U);
  EXPECT_EQ(reassembler.statistics().frames_complete, 2U);
  EXPECT_EQ(reassembler.statistics().frames_lost, 0U);
}

// Bytes of the header that all packets of a frame have in common.
TEST(Reassembler, APacketThatContradictsItsFrameIsRefused) {
  for (const std::size_t offset : {24U, 32U, 38U, 42U}) {  // exposure, freshness, count, height
    const std::vector<Datagram> packets = datagrams(frame_spec(100));
    Reassembler reassembler;
    push_all(reassembler, without(packets, 5));
    Datagram other = packets[5];
    other[offset] ^= std::byte{0x40};
    reseal(other);
    EXPECT_TRUE(push_all(reassembler, {other}).empty()) << offset;
    EXPECT_EQ(reassembler.statistics().bad_field, 1U) << offset;
    EXPECT_EQ(push_all(reassembler, {packets[5]}).size(), 1U) << offset;
    EXPECT_EQ(reassembler.statistics().frames_complete, 1U) << offset;
  }
}

TEST(Reassembler, APixelIsNotTakenTwice) {
  const std::vector<Datagram> packets = datagrams(frame_spec(100));
  Reassembler reassembler;
  push_all(reassembler, without(packets, 2));
  Datagram overlap = packets[3];  // the pixels of packet 3 with the index of packet 2
  wire::put_u16(std::span(overlap).subspan<36, 2>(), 2);
  overlap[60] ^= std::byte{1};
  reseal(overlap);
  push_all(reassembler, {overlap});
  EXPECT_EQ(reassembler.statistics().bad_field, 1U);
  reassembler.push(packets[2], kStart);
  const std::optional<Frame> frame = reassembler.take();
  ASSERT_TRUE(frame);
  EXPECT_TRUE(ExpectedImages(packets, 300, 5).equal(*frame));
}

TEST(Reassembler, FramesNobodyTakesAreDroppedOldestFirst) {
  Reassembler reassembler;
  for (std::uint32_t number = 100; number < 110; ++number) {
    for (const Datagram& packet : datagrams(frame_spec(number))) {
      reassembler.push(packet, kStart);
    }
  }
  for (std::uint32_t number = 106; number < 110; ++number) {
    const std::optional<Frame> frame = reassembler.take();
    ASSERT_TRUE(frame);
    EXPECT_EQ(frame->stamp.number, number);
  }
  EXPECT_FALSE(reassembler.take());
  EXPECT_EQ(reassembler.statistics().frames_dropped, 6U);
  EXPECT_EQ(reassembler.statistics().frames_complete, 4U);
}

}  // namespace
}  // namespace stof::client
