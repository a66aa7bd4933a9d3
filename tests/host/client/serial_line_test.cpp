#include "host/client/serial/serial_line.h"

#include <array>
#include <chrono>
#include <thread>
#include <vector>

#include <gtest/gtest.h>
#include <unistd.h>

#include "hal/framing/cobs.h"
#include "host/client/receiver.h"
#include "tests/host/client/sent_frame.h"
#include "tests/support/pty.h"

namespace stof::client {
namespace {

using test::Datagram;

constexpr Duration kLong = std::chrono::seconds(30);

// The far end of a line, written to from a thread: a pseudo-terminal holds little.
class FarEnd {
 public:
  FarEnd() { static_cast<void>(pty_.open()); }
  ~FarEnd() { finish(); }
  FarEnd(const FarEnd&) = delete;
  FarEnd& operator=(const FarEnd&) = delete;
  const std::string& name() const { return pty_.name(); }

  void send(std::vector<Datagram> packets) {
    finish();
    writer_ = std::thread([this, sent = std::move(packets)] {
      for (const Datagram& packet : sent) {
        std::vector<std::byte> code(hal::cobs_bound(packet.size()) + 1);
        code.resize(hal::cobs_encode(packet, code) + 1);
        code.back() = std::byte{0};
        std::span<const std::byte> left(code);
        while (!left.empty()) {
          const ssize_t taken = ::write(pty_.fd(), left.data(), left.size());
          if (taken > 0) {
            left = left.subspan(static_cast<std::size_t>(taken));
          } else {
            std::this_thread::sleep_for(std::chrono::milliseconds(1));
          }
        }
      }
    });
  }
  void finish() {
    if (writer_.joinable()) {
      writer_.join();
    }
  }
  void hang_up() {
    finish();
    pty_.close();
  }

 private:
  test::Pty pty_;
  std::thread writer_;
};

std::shared_ptr<SerialLine> open_line(const FarEnd& far) {
  auto line = SerialLine::open(far.name(), 921'600);
  EXPECT_TRUE(line) << (line ? "" : line.error().message);
  return line ? *line : nullptr;
}

std::vector<Datagram> frame(std::uint32_t number) {
  return test::datagrams(test::frame_spec(number));
}

Datagram answer() {
  wire::DatagramBuffer buffer{};
  const auto packet =
      wire::seal_packet({.type = wire::PacketType::kSettingsAnswer}, std::size_t{4}, buffer);
  return {packet.begin(), packet.end()};
}

TEST(SerialLine, AReceiverGetsTheFramesThatTravelOnIt) {
  FarEnd far;
  if (far.name().empty()) {
    GTEST_SKIP() << "this system makes no pseudo-terminals";
  }
  const auto line = open_line(far);
  ASSERT_NE(line, nullptr);
  auto receiver = Receiver::open({.line = line, .reassembler = {.max_age = kLong}});
  ASSERT_TRUE(receiver) << receiver.error().message;
  EXPECT_EQ(receiver->place(), far.name());
  EXPECT_FALSE(receiver->subscription());
  EXPECT_EQ(receiver->advice(), "");
  for (std::uint32_t number = 1; number <= 3; ++number) {
    far.send(frame(number));
    const Result<Frame> got = receiver->next(kLong);
    ASSERT_TRUE(got);
    EXPECT_EQ(got->stamp.number, number);
    EXPECT_TRUE(got->complete());
    EXPECT_EQ(receiver->sender(), "");
  }
  far.hang_up();
  EXPECT_EQ(receiver->next(kLong).error(), Status::kDeviceLost);
}

TEST(SerialLine, WhatOneOfTwoReadersReadsForTheOtherWaitsForIt) {
  FarEnd far;
  if (far.name().empty()) {
    GTEST_SKIP() << "this system makes no pseudo-terminals";
  }
  const auto line = open_line(far);
  ASSERT_NE(line, nullptr);
  auto receiver = Receiver::open({.line = line, .reassembler = {.max_age = kLong}});
  ASSERT_TRUE(receiver) << receiver.error().message;
  std::vector<Datagram> sent = frame(7);
  sent.push_back(answer());
  far.send(sent);
  // The asker reads through a whole frame to find its answer.
  const auto asked = line->take(SerialLine::For::kAsker, kLong);
  ASSERT_TRUE(asked);
  EXPECT_EQ(asked->bytes, answer());
  EXPECT_TRUE(line->holds(SerialLine::For::kReceiver));
  ASSERT_TRUE(receiver->next_due());
  EXPECT_LE(*receiver->next_due(), Time::clock::now());
  const Result<Frame> got = receiver->next(kLong);
  ASSERT_TRUE(got);
  EXPECT_EQ(got->stamp.number, 7U);
  EXPECT_TRUE(got->complete());
  // And the other way round.
  far.send({answer(), frame(8).front()});
  while (!line->holds(SerialLine::For::kAsker)) {
    static_cast<void>(receiver->next(std::chrono::milliseconds(1)));
  }
  EXPECT_TRUE(line->take(SerialLine::For::kAsker, Duration(0)));
}

TEST(SerialLine, WithoutAReceiverNothingWaitsForOne) {
  FarEnd far;
  if (far.name().empty()) {
    GTEST_SKIP() << "this system makes no pseudo-terminals";
  }
  const auto line = open_line(far);
  ASSERT_NE(line, nullptr);
  std::vector<Datagram> sent = frame(1);
  sent.push_back(answer());
  far.send(sent);
  EXPECT_TRUE(line->take(SerialLine::For::kAsker, kLong));
  EXPECT_FALSE(line->holds(SerialLine::For::kReceiver));
}

TEST(SerialLine, ALineHasNoSubscription) {
  FarEnd far;
  if (far.name().empty()) {
    GTEST_SKIP() << "this system makes no pseudo-terminals";
  }
  const auto line = open_line(far);
  ASSERT_NE(line, nullptr);
  const auto refused = Receiver::open({.sensor = "127.0.0.1", .line = line});
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().status, Status::kInvalidArgument);
  EXPECT_EQ(refused.error().message.find(far.name()), 0U);
}

}  // namespace
}  // namespace stof::client
