#include "firmware/pipeline/publisher.h"

#include <algorithm>
#include <array>
#include <chrono>
#include <optional>
#include <vector>

#include <gtest/gtest.h>

#include "firmware/wire/messages/calibration.h"
#include "firmware/wire/messages/frame_info.h"
#include "tests/firmware/pipeline/noise_scene.h"
#include "tests/firmware/wire/frame/coder_in_memory.h"

namespace stof::firmware {
namespace {

using namespace test;

using Datagrams = std::vector<std::vector<std::byte>>;

// Without what is no part of the frame.
Datagrams frame_of(emu::DatagramPort& port) {
  Datagrams frame;
  while (const auto sent = port.take_sent()) {
    const auto packet = wire::parse_packet(sent->bytes);
    EXPECT_TRUE(packet);
    if (packet && packet->header.type != wire::PacketType::kCalibration) {
      frame.emplace_back(sent->bytes.begin(), sent->bytes.end());
    }
  }
  return frame;
}

// That these are the frame's datagrams as a coder with memory for all of them makes them: but for
// the frame info, which tells times, and parity over it.
void expect_frame(const Datagrams& sent, Scene& scene, const wire::StreamChoice& choice) {
  stof::test::CoderInMemory coder({.device_id = 7, .session_id = 9}, kSizes, kLens);
  const wire::Datagrams whole = coder->code({}, {}, scene.images(), choice).value();
  ASSERT_EQ(sent.size(), whole.size());
  for (std::size_t i = 0; i < sent.size(); ++i) {
    const wire::PacketView is = wire::parse_packet(sent[i]).value();
    const wire::PacketView should = wire::parse_packet(whole[i]).value();
    ASSERT_EQ(is.header.type, should.header.type);
    ASSERT_EQ(is.header.index, should.header.index);
    ASSERT_EQ(is.header.count, should.header.count);
    if (is.header.type == wire::PacketType::kFrameInfo) {
      const auto info = wire::decode_frame_info(is.payload).value();
      const auto told = wire::decode_frame_info(should.payload).value();
      ASSERT_EQ(info.tiles, told.tiles);
      ASSERT_EQ(info.parity_groups, told.parity_groups);
    } else if (is.header.type == wire::PacketType::kTile) {
      ASSERT_EQ(is.header.stream, should.header.stream);
      ASSERT_EQ(is.header.codec, should.header.codec);
      ASSERT_EQ(is.header.flags, should.header.flags);
      ASSERT_EQ(is.header.first_row, should.header.first_row);
      ASSERT_EQ(is.header.first_column, should.header.first_column);
      ASSERT_EQ(is.header.pixel_count, should.header.pixel_count);
      ASSERT_TRUE(std::ranges::equal(is.payload, should.payload)) << i;
    }
  }
}

TEST(Publisher, AFrameLargerThanItsMemoryIsSentWhole) {
  for (const wire::Coding coding :
       {wire::Coding::kRaw, wire::Coding::kRvl, wire::Coding::kQuantised}) {
    for (const bool parity : {false, true}) {
      const wire::StreamChoice choice = everything(coding, parity);
      Sender sender(choice);
      for (std::uint64_t frame = 0; frame < 3; ++frame) {
        Scene scene(100 * frame);
        const hal::Time begin = sender.clock.now();
        ASSERT_EQ(sender.publish(scene), Status::kOk);
        EXPECT_LE(sender.clock.now(), begin + 20ms);
        const Datagrams sent = frame_of(sender.port);
        EXPECT_GT(sent.size(), 2 * wire::FrameCoder::usual_packets(kSizes));
        expect_frame(sent, scene, choice);
      }
      EXPECT_EQ(sender.events.counters.packets_dropped, 0U);
    }
  }
}

// A receiver takes a message that says otherwise for somebody else's.
TEST(Publisher, ACalibrationMessageSaysWhatTheFrameBesideItDoes) {
  const wire::StreamChoice choice = everything(wire::Coding::kRaw, false);
  Sender sender(choice);
  std::optional<wire::CalibrationPacket> told;
  int compared = 0;
  for (std::uint16_t k = 0; k < 24; ++k) {
    if (k % 3 == 0) {
      sender.publisher.set_params({.choice = choice,
                                   .period = 33ms + k * 1ms,
                                   .max_range = static_cast<dsp::QuarterMm>(8000 + 100 * (k / 6))});
    }
    sender.clock.wait_until(sender.clock.now() + 10ms);
    Scene scene(k);
    ASSERT_EQ(sender.publish(scene), Status::kOk) << k;
    told.reset();
    while (const auto sent = sender.port.take_sent()) {
      const wire::PacketView packet = wire::parse_packet(sent->bytes).value();
      EXPECT_EQ(packet.header.frame.number, k);
      if (packet.header.type == wire::PacketType::kCalibration) {
        told = wire::decode_calibration_packet(packet.payload).value();
      } else if (packet.header.type == wire::PacketType::kFrameInfo && told) {
        const wire::FrameInfo info = wire::decode_frame_info(packet.payload).value();
        EXPECT_EQ(info.period_ns, told->period_ns);
        EXPECT_EQ(info.max_range_um, told->max_range * told->depth_unit_um);
        EXPECT_EQ(info.calibration_fingerprint, told->fingerprint);
        ++compared;
      }
    }
  }
  EXPECT_EQ(compared, 8);
}

TEST(Publisher, EveryReceiverGetsALargeFrameWhole) {
  const wire::StreamChoice choice = everything(wire::Coding::kRaw, true);
  Sender sender(choice);
  const ReceiverList receivers = receivers_at_ports(2);
  sender.publisher.set_receivers(receivers);
  Scene scene(5);
  ASSERT_EQ(sender.publish(scene), Status::kOk);
  std::array<Datagrams, 2> got;
  while (const auto sent = sender.port.take_sent()) {
    if (wire::parse_packet(sent->bytes)->header.type != wire::PacketType::kCalibration) {
      got.at(sent->to.port - 1U).emplace_back(sent->bytes.begin(), sent->bytes.end());
    }
  }
  expect_frame(got[0], scene, choice);
  EXPECT_TRUE(got[0] == got[1]);
}

// What does not leave is counted, and what leaves says that it is not all.
TEST(Publisher, WhatAFullLinkDropsOfALargeFrameIsCounted) {
  const wire::StreamChoice choice = everything(wire::Coding::kRaw, true);
  Scene scene(1);
  Sender all(choice);
  ASSERT_EQ(all.publish(scene), Status::kOk);
  const Datagrams whole = frame_of(all.port);
  for (const int queue : {1, 2, 30, 100}) {
    Sender sender(choice, queue);
    EXPECT_EQ(sender.publish(scene), Status::kWouldBlock);
    const Counters& counters = sender.events.counters;
    EXPECT_EQ(counters.packets_sent, static_cast<std::size_t>(queue));  // with the calibration
    EXPECT_EQ(counters.packets_sent + counters.packets_dropped, whole.size() + 1);
    const Datagrams sent = frame_of(sender.port);
    ASSERT_EQ(sent.size(), static_cast<std::size_t>(queue) - 1);
    for (std::size_t i = 0; i < sent.size(); ++i) {
      EXPECT_TRUE(i == 0 || sent[i] == whole[i]) << i;
      EXPECT_EQ(wire::parse_packet(sent[i])->header.count,
                wire::parse_packet(whole[i])->header.count);
    }
  }
}

TEST(Publisher, AfterALargeFrameThatWasCutOffTheNextIsWhole) {
  const wire::StreamChoice choice = everything(wire::Coding::kRvl, true);
  for (const emu::FaultKind kind : emu::kAllFaultKinds) {
    Sender sender(choice, kQueue, {{.kind = kind, .call = 60, .every = 0, .duration = 1ms}});
    Scene first(3);
    static_cast<void>(sender.publish(first));
    EXPECT_EQ(sender.events.counters.packets_dropped, kind == emu::FaultKind::kVanish ? 1U : 0U);
    while (sender.port.take_sent()) {
    }
    sender.clock.wait_until(sender.clock.now() + 33ms);
    Scene second(4);
    ASSERT_EQ(sender.publish(second), Status::kOk);
    expect_frame(frame_of(sender.port), second, choice);
  }
}

// Goes away after some datagrams.
class LostPort final : public hal::DatagramPort {
 public:
  explicit LostPort(std::size_t datagrams) : left_(datagrams) {}
  Status send(const hal::Peer&, std::span<const std::span<const std::byte>> datagrams,
              std::size_t& sent) noexcept override {
    sent = std::min(left_, datagrams.size());
    left_ -= sent;
    return sent < datagrams.size() ? Status::kDeviceLost : Status::kOk;
  }
  Result<hal::Received> receive(std::span<std::byte>, hal::Duration) noexcept override {
    return fail(Status::kTimeout);
  }
  std::uint64_t overruns() const noexcept override { return 0; }
  bool take_unreachable(hal::Peer&) noexcept override { return false; }
  std::uint16_t port() const noexcept override { return 1; }

 private:
  std::size_t left_;
};

TEST(Publisher, SendsToAsManyAsMaySubscribe) {
  const wire::StreamChoice choice = everything(wire::Coding::kRaw, false);
  Scene scene(1);
  Sender one(choice);
  ASSERT_EQ(one.publish(scene), Status::kOk);
  Sender all(choice, kMostSubscribers * kQueue);
  all.publisher.set_receivers(receivers_at_ports(kMostSubscribers));
  ASSERT_EQ(all.publish(scene), Status::kOk);
  EXPECT_EQ(all.events.counters.packets_sent, kMostSubscribers * one.events.counters.packets_sent);
}

TEST(Publisher, WhatALostDeviceLeavesOfALargeFrameIsCounted) {
  const wire::StreamChoice choice = everything(wire::Coding::kRaw, true);
  Scene scene(1);
  Sender all(choice);
  ASSERT_EQ(all.publish(scene), Status::kOk);
  const std::uint64_t whole = all.events.counters.packets_sent;
  const ReceiverList receivers = receivers_at_ports(3);
  for (const std::size_t datagrams : {0U, 1U, 9U, 90U}) {
    LostPort port(datagrams);
    Sender sender(choice, 1, {}, &port);
    sender.publisher.set_receivers(receivers);
    EXPECT_EQ(sender.publish(scene), Status::kDeviceLost);
    EXPECT_EQ(sender.events.counters.packets_sent, datagrams);
    EXPECT_EQ(sender.events.counters.packets_dropped, receivers.count * whole - datagrams);
  }
}

// What each of three receivers gets: its datagrams as they were before they were signed, the
// counters in order.
struct Signed {
  Datagrams plain;
  std::vector<std::uint64_t> counters;
};
std::array<Signed, 3> got_by(emu::DatagramPort& port, const ReceiverList& receivers) {
  std::array<Signed, 3> got;
  while (const auto sent = port.take_sent()) {
    const std::size_t receiver = sent->to.port - 1U;
    const auto packet = wire::parse_packet(sent->bytes);
    EXPECT_TRUE(packet);
    EXPECT_LE(sent->bytes.size(), wire::kMaxDatagram);
    const auto signature = wire::signature_of(sent->bytes);
    const wire::StreamKey& key = receivers.keys.at(receiver);
    EXPECT_EQ(signature.has_value(), key.number != 0);
    if (signature) {
      EXPECT_EQ(signature->number, key.number);
      EXPECT_TRUE(wire::signed_with(wire::StreamTagger(key), *signature, sent->bytes));
      got.at(receiver).counters.push_back(signature->counter);
    }
    wire::DatagramBuffer space{};
    std::ranges::copy(packet->payload, wire::payload_space(space).begin());
    const auto plain = wire::seal_packet(packet->header, packet->payload.size(), space);
    got.at(receiver).plain.emplace_back(plain.begin(), plain.end());
  }
  return got;
}

std::vector<std::uint64_t> numbers(std::uint64_t first, std::size_t count) {
  std::vector<std::uint64_t> all(count);
  std::ranges::generate(all, [&] { return first++; });
  return all;
}

TEST(Publisher, SignsForEachWhoAskedAndCountsOn) {
  ASSERT_TRUE(wire::start_crypto());
  for (const int pace : {0, 60}) {
    Sender sender(everything(wire::Coding::kQuantised, true), 4 * kQueue);
    sender.publisher.set_params({.choice = everything(wire::Coding::kQuantised, true),
                                 .pace_percent = pace,
                                 .period = 33ms});
    ReceiverList receivers = receivers_at_ports(3);
    receivers.keys[0] = numbered_stream_key(1);
    receivers.keys[2] = numbered_stream_key(2);
    sender.publisher.set_receivers(receivers);
    Scene scene(1);
    ASSERT_EQ(sender.publish(scene), Status::kOk);
    sender.publisher.report({});
    const auto first = got_by(sender.port, receivers);
    EXPECT_GT(first[1].plain.size(), 100U);
    EXPECT_TRUE(first[0].plain == first[1].plain && first[2].plain == first[1].plain);
    EXPECT_EQ(first[0].counters, numbers(1, first[1].plain.size()));
    EXPECT_EQ(first[2].counters, first[0].counters);

    // The first one leaves: the last one is at another place of the list, and goes on.
    receivers.peers[0] = receivers.peers[2];
    receivers.keys[0] = receivers.keys[2];
    receivers.count = 1;
    sender.publisher.set_receivers(receivers);
    ASSERT_EQ(sender.publish(scene), Status::kOk);
    ReceiverList at_third = receivers_at_ports(3);
    at_third.keys[2] = numbered_stream_key(2);
    const auto second = got_by(sender.port, at_third);
    EXPECT_EQ(second[2].counters, numbers(first[2].counters.size() + 1, second[2].plain.size()));

    // Another key begins anew.
    receivers.keys[0] = at_third.keys[2] = numbered_stream_key(3);
    sender.publisher.set_receivers(receivers);
    ASSERT_EQ(sender.publish(scene), Status::kOk);
    const auto third = got_by(sender.port, at_third);
    EXPECT_EQ(third[2].counters, numbers(1, third[2].plain.size()));
  }
}

TEST(Publisher, WhatALostDeviceLeavesOfASignedFrameIsCounted) {
  const wire::StreamChoice choice = everything(wire::Coding::kRaw, true);
  Scene scene(1);
  Sender all(choice);
  ASSERT_EQ(all.publish(scene), Status::kOk);
  const std::uint64_t whole = all.events.counters.packets_sent;
  ReceiverList receivers = receivers_at_ports(3);
  receivers.keys[1] = numbered_stream_key(1);
  for (const std::size_t datagrams : {0U, 1U, 9U, 90U}) {
    LostPort port(datagrams);
    Sender sender(choice, 1, {}, &port);
    sender.publisher.set_receivers(receivers);
    EXPECT_EQ(sender.publish(scene), Status::kDeviceLost);
    EXPECT_EQ(sender.events.counters.packets_dropped, receivers.count * whole - datagrams);
  }
}

// Nothing of it is sent, and its number is missing.
TEST(Publisher, PicturesLargerThanSaidAreRefusedWhole) {
  const wire::StreamChoice choice = everything(wire::Coding::kQuantised, true);
  Sender sender(choice);
  Scene larger(1, kSizes.width + 1);
  EXPECT_EQ(sender.publish(larger), Status::kTooLarge);
  EXPECT_TRUE(frame_of(sender.port).empty());
  Scene usual(2);
  ASSERT_EQ(sender.publish(usual), Status::kOk);
  const Datagrams sent = frame_of(sender.port);
  expect_frame(sent, usual, choice);
  EXPECT_EQ(wire::parse_packet(sent[0])->header.frame.number, 1U);
}

}  // namespace
}  // namespace stof::firmware
