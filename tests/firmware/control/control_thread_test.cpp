#include "firmware/control/control_thread.h"

#include <list>

#include <gtest/gtest.h>

#include "tests/firmware/control/control_client.h"
#include "tests/firmware/control/sensor.h"

namespace stof::test {
namespace {

using namespace std::chrono_literals;
using wire::PacketType;
using wire::SubscribeResult;

// The longest one: whoever holds it stays, however slow this computer is.
constexpr std::uint16_t kLongLeaseMs = 10'000;

TEST(ControlThread, SubscribesOverTheNetwork) {
  Sensor sensor;
  ControlClient robot(sensor);
  EXPECT_EQ(robot.ask(), SubscribeResult::kOk);
  ASSERT_TRUE(sensor.reaches(1));
  const Bytes frame(100, std::byte{'f'});
  EXPECT_EQ(sensor.send(frame), Status::kOk);
  EXPECT_EQ(robot.receive(), frame);
  EXPECT_EQ(robot.ask(PacketType::kUnsubscribe), SubscribeResult::kEnded);
  EXPECT_TRUE(sensor.reaches(0));
}

TEST(ControlThread, TheFourthOfAHostIsRefusedUntilAnotherLeaves) {
  const Sensor sensor;
  std::list<ControlClient> robots;
  for (int i = 0; i < 3; ++i) {
    EXPECT_EQ(robots.emplace_back(sensor).ask(PacketType::kSubscribe, kLongLeaseMs),
              SubscribeResult::kOk);
  }
  ControlClient fourth(sensor);
  EXPECT_EQ(fourth.ask(), SubscribeResult::kFull);
  EXPECT_EQ(robots.front().ask(PacketType::kUnsubscribe), SubscribeResult::kEnded);
  EXPECT_EQ(fourth.ask(), SubscribeResult::kOk);
}

// Sends frames until so many are left.
bool drops_to(Sensor& sensor, std::size_t count) {
  const Bytes frame(100);
  for (int i = 0; i < 60'000 && sensor.list().count != count; ++i) {
    EXPECT_EQ(sensor.send(frame), Status::kOk);
    std::this_thread::sleep_for(1ms);
  }
  return sensor.list().count == count;
}

// Without a word, as a program that was killed. Its computer refuses what comes then, but so may
// anybody in its name: its lease has to end.
TEST(ControlThread, WhoEndsWithoutAWordIsForgottenWhenItsLeaseEnds) {
  Sensor sensor;
  ControlClient stays(sensor);
  EXPECT_EQ(stays.ask(PacketType::kSubscribe, kLongLeaseMs), SubscribeResult::kOk);
  const auto asked = std::chrono::steady_clock::now();
  {
    ControlClient leaves(sensor);
    EXPECT_EQ(leaves.ask(PacketType::kSubscribe, 2000), SubscribeResult::kOk);
    ASSERT_TRUE(sensor.reaches(2));
  }
  EXPECT_TRUE(drops_to(sensor, 1));
  EXPECT_GE(std::chrono::steady_clock::now() - asked, 2s);
}

// 10,000 with STOF_LONG=1; every tenth leaves without a word.
TEST(ControlThread, ComesAndGoesManyTimes) {
  Sensor sensor;
  ControlClient stays(sensor);
  const int rounds = long_or(10'000, 200);
  for (int i = 0; i < rounds; ++i) {
    ASSERT_EQ(stays.ask(PacketType::kSubscribe, kLongLeaseMs), SubscribeResult::kOk) << i;
    constexpr std::uint16_t kShortLeaseMs = 500;
    {
      ControlClient robot(sensor);
      const std::uint16_t lease_ms = i % 10 != 0 ? 0 : kShortLeaseMs;
      ASSERT_EQ(robot.ask(PacketType::kSubscribe, lease_ms), SubscribeResult::kOk) << i;
      if (i % 10 != 0) {
        ASSERT_EQ(robot.ask(PacketType::kUnsubscribe), SubscribeResult::kEnded) << i;
        continue;
      }
    }
    // Not until it is seen among them: its lease may be over before anybody looks.
    std::this_thread::sleep_for(kShortLeaseMs * 1ms);
    ASSERT_TRUE(drops_to(sensor, 1)) << i;
    while (stays.receive(0ns)) {  // the frames
    }
  }
}

TEST(ControlThread, EndsWithoutWaitingForAPacket) {
  for (int i = 0; i < 5; ++i) {
    const Sensor sensor;
  }
}

}  // namespace
}  // namespace stof::test
