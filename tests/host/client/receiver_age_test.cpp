// What a receiver does with what waited: a program that pauses, a queue that never empties, errors
// that answer earlier datagrams.
#include <atomic>
#include <chrono>
#include <thread>
#include <vector>

#include <gtest/gtest.h>

#include "host/client/receiver.h"
#include "host/client/session/session_tracker.h"
#include "posix/datagram_batch.h"
#include "tests/host/client/loopback_sender.h"
#include "tests/host/client/sent_frame.h"

namespace stof::client {
namespace {

using namespace std::chrono_literals;
using test::LoopbackSender;

// What waited for longer is old.
constexpr Duration kAge = 2s;

Receiver open_loopback() {
  auto receiver =
      Receiver::open({.address = "127.0.0.1", .port = 0, .reassembler = {.max_age = kAge}});
  if (!receiver) {
    ADD_FAILURE() << receiver.error().message;
    std::abort();
  }
  return std::move(*receiver);
}

// A frame of one packet.
test::Datagram frame(std::uint32_t number, std::uint32_t freshness) {
  return test::datagrams({.number = number, .freshness = freshness, .width = 0, .height = 0})
      .front();
}

bool stamps_arrivals() {
  const posix::UdpSocket socket(AF_INET);
  return socket.stamp_arrivals() == 0;
}

TEST(ReceiverAge, AfterAPauseTheNextFrameIsANewOne) {
  if (!stamps_arrivals()) {
    GTEST_SKIP() << "this system does not stamp arrivals";
  }
  Receiver receiver = open_loopback();
  LoopbackSender sender(receiver.port());
  for (std::uint32_t number = 1; number <= 20; ++number) {
    ASSERT_EQ(sender.send(frame(number, number)), Status::kOk);
  }
  ASSERT_TRUE(receiver.next(10s)) << "the others wait: read already, finished, or in the socket";
  std::this_thread::sleep_for(kAge + 100ms);
  EXPECT_EQ(receiver.next(0ms).error(), Status::kTimeout);
  EXPECT_TRUE(receiver.link().silent);
  ASSERT_EQ(sender.send(frame(40, 40)), Status::kOk);
  const Result<Frame> newest = receiver.next(10s);
  ASSERT_TRUE(newest);
  EXPECT_EQ(newest->stamp.number, 40U);
  EXPECT_FALSE(receiver.link().silent);
  ASSERT_TRUE(receiver.link().frame_age);
  EXPECT_LT(*receiver.link().frame_age, 10s);
  EXPECT_EQ(receiver.statistics().frames_old, 19U);
  EXPECT_EQ(receiver.statistics().old, 19U);
  EXPECT_EQ(receiver.statistics().frames_lost, 19U);
}

TEST(ReceiverAge, ReturnsInTimeWhileStaleFramesComeFasterThanItLooks) {
  Receiver receiver = open_loopback();
  std::atomic<bool> ended{false};
  std::jthread flood([&ended, port = receiver.port()] {
    LoopbackSender sender(port);
    std::uint32_t number = 0;
    while (!ended) {
      static_cast<void>(sender.send(frame(++number, 1)));
    }
  });
  static_cast<void>(receiver.next(10s));  // the only fresh one
  for (const Duration timeout : {Duration(0ms), Duration(50ms)}) {
    const Time begin = Time::clock::now();
    EXPECT_FALSE(receiver.next(timeout));
    EXPECT_LT(Time::clock::now() - begin, 20s);
  }
  ended = true;
}

TEST(ReceiverAge, SaysThatTheSensorStartedAgainAndThatSomebodyForges) {
  Receiver receiver = open_loopback();
  LoopbackSender sender(receiver.port());
  EXPECT_FALSE(receiver.link().frame_age);
  ASSERT_EQ(sender.send(frame(1, 1)), Status::kOk);
  ASSERT_TRUE(receiver.next(10s));
  EXPECT_FALSE(receiver.link().restarted);
  EXPECT_FALSE(receiver.link().forged_traffic);
  ASSERT_EQ(sender.send(frame(1U << 30, 2)), Status::kOk);
  EXPECT_FALSE(receiver.next(10ms));
  EXPECT_TRUE(receiver.link().forged_traffic);
  EXPECT_FALSE(receiver.link_watch().state(Time::clock::now() + 10s).forged_traffic);
  test::FrameSpec again{.number = 1, .freshness = 1, .width = 0, .height = 0};
  again.origin.session_id = 99;
  std::this_thread::sleep_for(SessionTracker::kSilence);
  ASSERT_EQ(sender.send(test::datagrams(again).front()), Status::kOk);
  ASSERT_TRUE(receiver.next(10s));
  EXPECT_TRUE(receiver.link().restarted);
}

}  // namespace
}  // namespace stof::client
