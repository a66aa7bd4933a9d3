#include <chrono>
#include <optional>
#include <string>
#include <thread>
#include <vector>

#include <gtest/gtest.h>

#include "host/client/receiver.h"
#include "tests/firmware/control/requests.h"
#include "tests/firmware/control/sensor.h"
#include "tests/firmware/keys/some_keys.h"
#include "tests/host/client/sent_frame.h"

// Receiver against the appliance's own port, gate and thread.
namespace stof::client {
namespace {

using namespace std::chrono_literals;
using test::datagrams;
using test::frame_spec;
using test::Sensor;

Receiver subscribed(const Sensor& sensor, ReceiverOptions options = {}) {
  options.sensor = "127.0.0.1:" + std::to_string(sensor.number());
  options.reassembler.max_age = 600s;  // whatever else this computer does
  options.reassembler.frame_timeout = 600s;
  auto receiver = Receiver::open(options);
  if (!receiver) {
    ADD_FAILURE() << receiver.error().message;
    std::abort();
  }
  return std::move(*receiver);
}

// Turns of next() until the condition holds; a minute at most.
template <typename Condition>
bool until(Receiver& receiver, Condition condition) {
  for (int i = 0; i < 12'000 && !condition(); ++i) {
    static_cast<void>(receiver.next(5ms));
  }
  return condition();
}

void send_frame(Sensor& sensor, std::uint32_t number, std::uint32_t session = 1) {
  test::FrameSpec spec = frame_spec(number);
  spec.origin = {.device_id = Sensor::kDevice, .session_id = session};
  for (const test::Datagram& datagram : datagrams(spec)) {
    ASSERT_EQ(sensor.send(datagram), Status::kOk);
  }
}

TEST(SubscribedReceiver, SubscribesReceivesAndLeaves) {
  Sensor sensor;
  {
    Receiver receiver = subscribed(sensor);
    EXPECT_EQ(receiver.subscription(), Subscription::State::kAsking);
    ASSERT_TRUE(until(receiver, [&] { return sensor.list().count == 1; }));
    ASSERT_TRUE(
        until(receiver, [&] { return receiver.subscription() == Subscription::State::kActive; }));
    for (std::uint32_t number = 1; number <= 5; ++number) {
      send_frame(sensor, number);
      const Result<Frame> frame = receiver.next(10s);
      ASSERT_TRUE(frame);
      EXPECT_EQ(frame->stamp.number, number);
      EXPECT_TRUE(frame->complete());
    }
    EXPECT_EQ(receiver.statistics().packets(), receiver.statistics().packets_ok);
    EXPECT_EQ(receiver.place(), "127.0.0.1:" + std::to_string(sensor.number()));
  }
  EXPECT_TRUE(sensor.reaches(0));  // at once, not after the lease
}

TEST(SubscribedReceiver, ComesBackWhenTheSensorStartsAnew) {
  auto sensor = std::make_unique<Sensor>();
  const std::uint16_t number = sensor->number();
  Receiver receiver = subscribed(*sensor);
  ASSERT_TRUE(until(receiver, [&] { return sensor->list().count == 1; }));
  sensor.reset();
  static_cast<void>(receiver.next(50ms));
  sensor = std::make_unique<Sensor>(nullptr, number, /*session=*/2);
  ASSERT_TRUE(until(receiver, [&] { return sensor->list().count == 1; }));
  send_frame(*sensor, 1, 2);
  EXPECT_TRUE(receiver.next(10s));
}

// A stranger who knows the sensor's number and does not see what is asked.
TEST(SubscribedReceiver, BelievesNoSessionThatNoAnswerNamed) {
  Sensor sensor;
  Receiver receiver = subscribed(sensor);
  ASSERT_TRUE(
      until(receiver, [&] { return receiver.subscription() == Subscription::State::kActive; }));
  send_frame(sensor, 1, 77);
  send_frame(sensor, 1);
  const Result<Frame> frame = receiver.next(10s);
  ASSERT_TRUE(frame);
  EXPECT_EQ(frame->origin.session_id, 1U);
  EXPECT_EQ(receiver.statistics().sessions, 1U);
  EXPECT_EQ(receiver.statistics().foreign, 13U);
  // Not what the sensor sent before it started again: its own session goes on.
  std::uint32_t number = 2;
  for (; number < 100 && !receiver.link().forged_traffic; ++number) {
    send_frame(sensor, number);
    EXPECT_TRUE(receiver.next(10s));
    std::this_thread::sleep_for(20ms);
  }
  EXPECT_LT(number, 100U);
  EXPECT_EQ(receiver.statistics().sessions, 1U);
}

TEST(SubscribedReceiver, TheFourthOfAHostKnowsWhyNothingComes) {
  Sensor sensor;
  std::vector<Receiver> receivers;
  for (std::size_t i = 0; i < 3; ++i) {
    receivers.push_back(subscribed(sensor));
    ASSERT_TRUE(until(receivers.back(), [&] { return sensor.list().count == i + 1; }));
  }
  Receiver fourth = subscribed(sensor);
  EXPECT_TRUE(until(fourth, [&] { return fourth.subscription() == Subscription::State::kFull; }));
  EXPECT_EQ(sensor.list().count, 3U);
  EXPECT_FALSE(fourth.link().forged_traffic);
  // The sensor does not: somebody in its place.
  hal::Peer where = sensor.list().peers[0];
  where.port = fourth.port();
  EXPECT_TRUE(until(fourth, [&] {
    for (const test::Datagram& datagram : datagrams(frame_spec(1))) {
      const std::span<const std::byte> bytes = datagram;
      std::size_t sent = 0;
      EXPECT_EQ(sensor.port->send(where, std::span(&bytes, 1), sent), Status::kOk);
    }
    return fourth.link().forged_traffic;
  }));
  receivers.clear();
  EXPECT_TRUE(until(fourth, [&] { return fourth.subscription() == Subscription::State::kActive; }));
}

// The same without waiting: SubscriptionTest.ACallEverySecondIsEnough.
TEST(SubscribedReceiver, ASlowCallerKeepsItsLease) {
  const int seconds = test::long_or(20, 0);
  if (seconds == 0) {
    GTEST_SKIP() << "takes 20 s: set STOF_LONG=1";
  }
  Sensor sensor;
  Receiver receiver = subscribed(sensor);
  ASSERT_TRUE(
      until(receiver, [&] { return receiver.subscription() == Subscription::State::kActive; }));
  ASSERT_TRUE(sensor.reaches(1));
  for (int i = 0; i < seconds; ++i) {
    std::this_thread::sleep_for(1s);
    ASSERT_EQ(sensor.list().count, 1U) << i;
    static_cast<void>(receiver.next(0ms));
  }
}

TEST(SubscribedReceiver, OfSignedStreamsSaysThatNoKeyIsKnown) {
  const Sensor sensor;
  ReceiverOptions options;
  options.subscription.signed_streams = true;
  wire::Key key = test::numbered_key(4, wire::Role::kView);
  key.device = Sensor::kDevice;
  ASSERT_EQ(options.subscription.keys.add(key), Status::kOk);
  Receiver receiver = subscribed(sensor, options);
  EXPECT_FALSE(receiver.link().no_key);
  EXPECT_TRUE(until(receiver, [&] { return receiver.link().no_key; }));
  EXPECT_EQ(receiver.subscription(), Subscription::State::kNoKey);
}

TEST(SubscribedReceiver, SaysThatNobodyListens) {
  std::uint16_t closed = 0;
  {
    closed = Sensor().number();
  }
  auto receiver = Receiver::open({.sensor = "127.0.0.1:" + std::to_string(closed)});
  ASSERT_TRUE(receiver);
  bool refused = false;
  EXPECT_TRUE(until(*receiver, [&] { return refused = refused || receiver->take_refusal(); }));
  EXPECT_EQ(receiver->next(0ms).error(), Status::kTimeout);
}

TEST(SubscribedReceiver, HearsItsSensorAlone) {
  Sensor sensor;
  Sensor stranger;
  Receiver receiver = subscribed(sensor);
  ASSERT_TRUE(until(receiver, [&] { return sensor.list().count == 1; }));
  for (const test::Datagram& datagram : datagrams(frame_spec(1))) {
    const std::span<const std::byte> bytes = datagram;
    std::size_t sent = 0;
    ASSERT_EQ(stranger.port->send(sensor.list().peers[0], std::span(&bytes, 1), sent), Status::kOk);
  }
  EXPECT_FALSE(receiver.next(50ms));
  EXPECT_EQ(receiver.statistics().packets(), 0U);
}

TEST(SubscribedReceiver, SaysWhatIsWrongWithASensorsAddress) {
  for (const std::string bad :
       {":7560", "localhost:0", "localhost:65536", "localhost:x", "[::1", "[::1]x", "[]", "a..b"}) {
    const auto receiver = Receiver::open({.sensor = bad});
    ASSERT_FALSE(receiver) << bad;
    EXPECT_NE(receiver.error().message.find("'" + bad + "'"), std::string::npos);
    EXPECT_EQ(receiver.error().message.find('\n'), std::string::npos);
  }
}

TEST(ResolveSensor, TakesTheDefaultPortAndIpv6) {
  const auto text = [](std::string_view sensor) {
    const auto addresses = resolve_sensor(sensor);
    return addresses ? addresses->front().text() : addresses.error().message;
  };
  EXPECT_EQ(text("127.0.0.1"), "127.0.0.1:7560");
  EXPECT_EQ(text("127.0.0.1:1"), "127.0.0.1:1");
  EXPECT_EQ(text("::1"), "[::1]:7560");
  EXPECT_EQ(text("[::1]"), "[::1]:7560");
  EXPECT_EQ(text("[::1]:65535"), "[::1]:65535");
}

}  // namespace
}  // namespace stof::client
