#include "firmware/control/lease_table.h"

#include <gtest/gtest.h>

#include "tests/firmware/control/handler_parts.h"
#include "tests/firmware/control/requests.h"
#include "tests/firmware/keys/some_keys.h"

namespace stof::test {
namespace {

using namespace std::chrono_literals;
using firmware::LeaseTable;
using firmware::ReceiverList;

std::vector<hal::Peer> peers(const LeaseTable& subscribers) {
  const ReceiverList list = subscribers.list();
  return {list.all().begin(), list.all().end()};
}
using Peers = std::vector<hal::Peer>;

TEST(LeaseTable, GrantsWithinLimits) {
  EXPECT_EQ(LeaseTable::granted(0), 3s);
  EXPECT_EQ(LeaseTable::granted(1), 500ms);
  EXPECT_EQ(LeaseTable::granted(499), 500ms);
  EXPECT_EQ(LeaseTable::granted(2345), 2345ms);
  EXPECT_EQ(LeaseTable::granted(65535), 10s);
}

TEST(LeaseTable, TakesFourAndRenewsTheseWhileFull) {
  LeaseTable subscribers;
  for (std::uint8_t i = 1; i <= 4; ++i) {
    EXPECT_TRUE(subscribers.subscribe(peer(i), 3s, kStart));
  }
  EXPECT_FALSE(subscribers.subscribe(peer(5), 3s, kStart));
  EXPECT_FALSE(subscribers.subscribe(peer(1, 5001), 3s, kStart));  // another port is another one
  EXPECT_TRUE(subscribers.subscribe(peer(3), 3s, kStart + 1s));
  EXPECT_EQ(subscribers.count(), 4U);
  subscribers.expire(kStart + 3s);
  EXPECT_EQ(peers(subscribers), (Peers{peer(3)}));
  EXPECT_TRUE(subscribers.subscribe(peer(5), 3s, kStart + 3s));
}

// A receiver that asks at another address of the sensor is the same one, and has its stream from
// there.
TEST(LeaseTable, AStreamComesFromTheAddressThatWasAskedLast) {
  LeaseTable subscribers;
  hal::Peer robot = peer(1);
  EXPECT_TRUE(subscribers.subscribe(robot, 3s, kStart));
  const ReceiverList before = subscribers.list();
  robot.own[15] = 7;
  EXPECT_TRUE(subscribers.subscribe(robot, 3s, kStart));
  EXPECT_EQ(subscribers.count(), 1U);
  EXPECT_EQ(subscribers.list().peers[0].own, robot.own);
  EXPECT_FALSE(subscribers.list() == before) << "the loop would not be told";
}

TEST(LeaseTable, OneHostNeverHasAllPlaces) {
  LeaseTable subscribers;
  for (std::uint16_t port = 1; port <= 3; ++port) {
    EXPECT_TRUE(subscribers.subscribe(peer(66, port), 10s, kStart));
  }
  EXPECT_FALSE(subscribers.subscribe(peer(66, 4), 10s, kStart));
  EXPECT_TRUE(subscribers.subscribe(peer(66, 2), 10s, kStart)) << "renews";
  EXPECT_TRUE(subscribers.subscribe(peer(7), 10s, kStart)) << "somebody new gets in";
  subscribers.unsubscribe(peer(66, 1));
  EXPECT_TRUE(subscribers.subscribe(peer(66, 4), 10s, kStart));
}

TEST(LeaseTable, LeaseEndsWhenItsTimeIsOver) {
  LeaseTable subscribers;
  EXPECT_TRUE(subscribers.subscribe(peer(1), 3s, kStart));
  subscribers.expire(kStart + 3s - 1ns);
  EXPECT_EQ(subscribers.count(), 1U);
  subscribers.expire(kStart + 3s);
  EXPECT_EQ(subscribers.count(), 0U);
}

TEST(LeaseTable, ALaterShorterLeaseTakesNothingAway) {
  LeaseTable subscribers;
  EXPECT_TRUE(subscribers.subscribe(peer(1), 10s, kStart));
  EXPECT_TRUE(subscribers.subscribe(peer(1), 500ms, kStart + 1s));
  subscribers.expire(kStart + 9s);
  EXPECT_EQ(subscribers.count(), 1U);
}

TEST(LeaseTable, WhoLeavesLeavesTheOthersInOrder) {
  LeaseTable subscribers;
  for (std::uint8_t i = 1; i <= 4; ++i) {
    EXPECT_TRUE(subscribers.subscribe(peer(i), 3s, kStart));
  }
  subscribers.unsubscribe(peer(2));
  subscribers.unsubscribe(peer(9));
  subscribers.refused(peer(4), kStart);
  subscribers.refused(peer(8), kStart);
  EXPECT_EQ(peers(subscribers), (Peers{peer(1), peer(3), peer(4)}));
  EXPECT_FALSE(subscribers.list().refused);
}

TEST(LeaseTable, FixedOnesStay) {
  LeaseTable subscribers;
  EXPECT_TRUE(subscribers.fix(peer(1)));
  subscribers.unsubscribe(peer(1));
  subscribers.expire(kStart + 1000s);
  EXPECT_TRUE(subscribers.subscribe(peer(1), 500ms, kStart));
  subscribers.expire(kStart + 1000s);
  EXPECT_EQ(peers(subscribers), (Peers{peer(1)}));
  for (std::uint8_t i = 2; i <= 4; ++i) {
    EXPECT_TRUE(subscribers.fix(peer(i)));
  }
  EXPECT_FALSE(subscribers.fix(peer(5)));
  EXPECT_FALSE(subscribers.subscribe(peer(5), 3s, kStart));
}

TEST(LeaseTable, ASilentFixedDestinationIsToldWhileItRefuses) {
  LeaseTable subscribers;
  EXPECT_TRUE(subscribers.fix(peer(1)));
  EXPECT_FALSE(subscribers.list().refused);
  subscribers.refused(peer(1), kStart);
  EXPECT_TRUE(subscribers.list().refused);
  EXPECT_EQ(subscribers.count(), 1U);
  subscribers.expire(kStart + LeaseTable::kRefusal - 1ns);
  EXPECT_TRUE(subscribers.list().refused);
  subscribers.expire(kStart + LeaseTable::kRefusal);
  EXPECT_FALSE(subscribers.list().refused);
}

TEST(LeaseTable, AKeyThatEndsTakesItsLeaseAlongAndLeavesAFixedDestinationUnsigned) {
  ASSERT_TRUE(wire::start_crypto());
  LeaseTable subscribers;
  EXPECT_TRUE(subscribers.fix(peer(1)));
  wire::KeyTable keys;
  ASSERT_EQ(keys.add(numbered_key(7)), Status::kOk);
  ASSERT_EQ(keys.add(numbered_key(8)), Status::kOk);
  ASSERT_NE(subscribers.subscribe_signed(peer(1), {.key_id = 7}, 3s, kStart), nullptr);
  ASSERT_NE(subscribers.subscribe_signed(peer(2), {.key_id = 7}, 3s, kStart), nullptr);
  ASSERT_NE(subscribers.subscribe_signed(peer(3), {.key_id = 8}, 3s, kStart), nullptr);
  EXPECT_TRUE(subscribers.subscribe(peer(4), 3s, kStart));
  subscribers.drop_ended_keys(keys);
  EXPECT_EQ(subscribers.count(), 4U);
  ASSERT_TRUE(keys.remove(7));
  subscribers.drop_ended_keys(keys);
  EXPECT_EQ(peers(subscribers), (Peers{peer(1), peer(3), peer(4)}));
  EXPECT_EQ(subscribers.list().keys[0].number, 0U);
  EXPECT_NE(subscribers.list().keys[1].number, 0U);
}

}  // namespace
}  // namespace stof::test
