#include "host/client/receiver.h"

#include <chrono>
#include <optional>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "tests/host/client/loopback_sender.h"
#include "tests/host/client/sent_frame.h"
#include "tests/support/udp_abilities.h"

namespace stof::client {
namespace {

using std::chrono::milliseconds;
using std::chrono::seconds;
using test::Datagram;
using test::datagrams;
using test::ExpectedImages;
using test::frame_spec;
using test::FrameSpec;
using test::LoopbackSender;

Receiver open_loopback(ReceiverOptions options = {}) {
  options.address = "127.0.0.1";
  options.port = 0;
  // What this computer does meanwhile makes nothing old, nor a frame late.
  options.reassembler.max_age = options.reassembler.max_age.value_or(seconds(600));
  options.reassembler.frame_timeout = options.reassembler.frame_timeout.value_or(seconds(600));
  auto receiver = Receiver::open(options);
  if (!receiver) {
    ADD_FAILURE() << receiver.error().message;
    std::abort();
  }
  return std::move(*receiver);
}

void send_all(LoopbackSender& sender, const std::vector<Datagram>& packets) {
  for (const Datagram& packet : packets) {
    ASSERT_EQ(sender.send(packet), Status::kOk);
  }
}

TEST(Receiver, ThirtyFramesComeOverLoopbackPixelForPixel) {
  Receiver receiver = open_loopback();
  LoopbackSender sender(receiver.port());
  ASSERT_TRUE(sender.connected());
  for (std::uint32_t number = 1; number <= 30; ++number) {
    FrameSpec spec = frame_spec(number);
    spec.width = 161;  // 73 packets: more than one read
    spec.height = 75;
    const std::vector<Datagram> packets = datagrams(spec);
    if (number == 1) {
      send_all(sender, {test::calibration_datagram(spec, 33'333'333)});
    }
    send_all(sender, packets);
    const Result<Frame> frame = receiver.next(seconds(20));
    ASSERT_TRUE(frame) << "frame " << number << ": " << to_string(frame.error());
    ASSERT_EQ(frame->stamp.number, number);
    ASSERT_TRUE(frame->complete());
    ASSERT_TRUE(frame->calibration);
    ASSERT_TRUE(ExpectedImages(packets, 161, 75).equal(*frame));
  }
  EXPECT_EQ(receiver.statistics().frames_complete, 30U);
  EXPECT_EQ(receiver.statistics().packets_missing, 0U);
  EXPECT_EQ(receiver.statistics().socket_drops, 0U);
}

TEST(Receiver, FramesOfOnePacketEachComeOneByOne) {
  Receiver receiver = open_loopback();
  LoopbackSender sender(receiver.port());
  for (std::uint32_t number = 1; number <= 100; ++number) {
    send_all(sender, datagrams({.number = number, .freshness = number, .width = 0, .height = 0}));
  }
  for (std::uint32_t number = 1; number <= 100; ++number) {
    const Result<Frame> frame = receiver.next(seconds(20));
    ASSERT_TRUE(frame);
    ASSERT_EQ(frame->stamp.number, number);
  }
  EXPECT_EQ(receiver.next(milliseconds(0)).error(), Status::kTimeout);
}

TEST(Receiver, SaysTimeoutWhenNothingComes) {
  Receiver receiver = open_loopback();
  EXPECT_EQ(receiver.next(milliseconds(0)).error(), Status::kTimeout);
  EXPECT_EQ(receiver.next(milliseconds(20)).error(), Status::kTimeout);
  EXPECT_EQ(receiver.next(milliseconds(-5)).error(), Status::kTimeout);
}

TEST(Receiver, AnIncompleteFrameComesWhenTheStreamStops) {
  Receiver receiver = open_loopback({.reassembler = {.frame_timeout = milliseconds(1)}});
  LoopbackSender sender(receiver.port());
  std::vector<Datagram> packets = datagrams(frame_spec(1));
  packets.erase(packets.begin() + 6);
  send_all(sender, packets);
  const Result<Frame> frame = receiver.next(seconds(20));
  ASSERT_TRUE(frame);
  EXPECT_EQ(frame->missing_packets, 1U);
  EXPECT_TRUE(ExpectedImages(packets, 300, 5).equal(*frame));
}

// A timeout that has always passed: what already lies in the socket is read before anything
// expires.
TEST(Receiver, ASlowReaderLosesNothingThatLiesInTheSocket) {
  Receiver receiver = open_loopback({.reassembler = {.frame_timeout = Duration(0)}});
  LoopbackSender sender(receiver.port());
  FrameSpec spec = frame_spec(1);
  spec.height = 70;  // 165 packets: three reads
  send_all(sender, datagrams(spec));
  const Result<Frame> frame = receiver.next(seconds(20));
  ASSERT_TRUE(frame);
  EXPECT_TRUE(frame->complete());
}

TEST(Receiver, AForeignDatagramIsCountedAndIgnored) {
  Receiver receiver = open_loopback();
  LoopbackSender sender(receiver.port());
  send_all(sender, {Datagram{}, Datagram(4000, std::byte{7}), Datagram(1500, std::byte{'S'})});
  send_all(sender, datagrams(frame_spec(1)));
  EXPECT_TRUE(receiver.next(seconds(20)));
  EXPECT_EQ(receiver.statistics().truncated, 1U);
  EXPECT_EQ(receiver.statistics().bad_magic, 2U);
  EXPECT_EQ(receiver.statistics().packets_ok, 13U);
}

TEST(Receiver, TellsLossInItsOwnBufferApart) {
  if (!test::counts_overruns()) {
    GTEST_SKIP() << "this system does not count datagrams that find the buffer full";
  }
  Receiver receiver =
      open_loopback({.socket_buffer = 8192, .reassembler = {.frame_timeout = milliseconds(100)}});
  LoopbackSender sender(receiver.port());
  const std::vector<Datagram> packets = datagrams(frame_spec(1));
  for (int i = 0; i < 20; ++i) {
    send_all(sender, packets);
  }
  EXPECT_TRUE(receiver.next(seconds(20)));
  static_cast<void>(receiver.next(milliseconds(0)));
  send_all(sender, {packets.front()});  // carries the count
  static_cast<void>(receiver.next(milliseconds(0)));
  const Statistics& statistics = receiver.statistics();
  EXPECT_GT(statistics.socket_drops, 0U);
  EXPECT_EQ(statistics.socket_drops + statistics.packets(), 20U * 13U + 1U);
}

TEST(Receiver, AdvisesExactlyWhenTheBufferIsSmallerThanAsked) {
  for (const int asked : {4096, 4 << 20, 1 << 30}) {
    const Receiver receiver = open_loopback({.socket_buffer = asked});
    EXPECT_GT(receiver.socket_buffer(), 0);
    EXPECT_EQ(receiver.advice().empty(), receiver.socket_buffer() >= asked) << asked;
    if (!receiver.advice().empty()) {
      EXPECT_NE(receiver.advice().find("net.core.rmem_max"), std::string::npos);
    }
  }
}

TEST(Receiver, SaysWhatIsWrongWithAnAddress) {
  const auto receiver = Receiver::open({.address = "no.such"});
  ASSERT_FALSE(receiver);
  EXPECT_EQ(receiver.error().status, Status::kInvalidArgument);
  EXPECT_NE(receiver.error().message.find("no.such"), std::string::npos);
}

TEST(Receiver, SaysThatAPortIsTaken) {
  const Receiver first = open_loopback();
  const auto second = Receiver::open({.address = "127.0.0.1", .port = first.port()});
  ASSERT_FALSE(second);
  EXPECT_EQ(second.error().status, Status::kDeviceError);
  EXPECT_NE(second.error().message.find(std::to_string(first.port())), std::string::npos);
}

TEST(Receiver, CanBeMovedBetweenTwoPackets) {
  Receiver first = open_loopback();
  LoopbackSender sender(first.port());
  const std::vector<Datagram> packets = datagrams(frame_spec(1));
  send_all(sender, {packets.begin(), packets.begin() + 5});
  EXPECT_EQ(first.next(milliseconds(0)).error(), Status::kTimeout);
  Receiver second = std::move(first);
  send_all(sender, {packets.begin() + 5, packets.end()});
  EXPECT_TRUE(second.next(seconds(20)));
}

}  // namespace
}  // namespace stof::client
