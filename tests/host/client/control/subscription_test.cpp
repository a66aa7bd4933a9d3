#include "host/client/control/subscription.h"

#include <utility>
#include <vector>

#include <gtest/gtest.h>

#include "tests/firmware/control/requests.h"

namespace stof::client {
namespace {

using namespace std::chrono_literals;
using test::Bytes;
using wire::PacketType;
using wire::SubscribeResult;

constexpr Time kStart{1000s};

struct Sent {
  PacketType type;
  wire::Subscribe request;
  std::uint32_t device_id;
};

std::optional<Sent> read(std::span<const std::byte> datagram) {
  const auto packet = wire::parse_packet(datagram);
  if (!packet) {
    EXPECT_TRUE(datagram.empty());
    return std::nullopt;
  }
  const Result<wire::Subscribe> request = wire::decode_subscribe(packet->payload);
  EXPECT_TRUE(request);
  return Sent{.type = packet->header.type,
              .request = request.value_or(wire::Subscribe{}),
              .device_id = packet->header.origin.device_id};
}

Bytes answer(const wire::Subscribed& subscribed, std::uint32_t device_id = 0x51) {
  std::array<std::byte, wire::kSubscribedBytes> payload;
  wire::encode_subscribed(subscribed, payload);
  return test::sealed(PacketType::kSubscribed, payload, device_id);
}

class SubscriptionTest : public testing::Test {
 protected:
  // The request that is due, which has to be there.
  wire::Subscribe asked(Time now) {
    const std::optional<Sent> sent = read(subscription_.due(now));
    EXPECT_TRUE(sent);
    return sent ? sent->request : wire::Subscribe{};
  }
  bool silent(Time now) { return subscription_.due(now).empty(); }
  void reply(const wire::Subscribe& request, SubscribeResult result, Time now,
             std::uint64_t cookie = 7, std::uint16_t lease_ms = 3000) {
    EXPECT_TRUE(subscription_.take(answer({.request_id = request.request_id,
                                           .result = result,
                                           .lease_ms = lease_ms,
                                           .cookie = cookie}),
                                   now));
  }
  // Subscribed since kStart.
  void join() {
    reply(asked(kStart), SubscribeResult::kCookie, kStart);
    reply(asked(kStart), SubscribeResult::kOk, kStart);
    EXPECT_EQ(subscription_.state(), Subscription::State::kActive);
  }

  Subscription subscription_{{}, 0xFFFFFFFE};  // request numbers wrap
};

TEST_F(SubscriptionTest, AsksForRawPicturesEachTimeAndIsSubscribedAlsoWhereItGetsNone) {
  const wire::RawRequest raw{.pictures = 7, .every = 5};
  subscription_ = Subscription({.raw = raw}, 10);
  reply(asked(kStart), SubscribeResult::kCookie, kStart);
  for (const SubscribeResult result :
       {SubscribeResult::kRawTaken, SubscribeResult::kRawDenied, SubscribeResult::kOk}) {
    const Time now = std::max(kStart, subscription_.next_due());
    const wire::Subscribe request = asked(now);
    EXPECT_EQ(request.raw, raw);
    reply(request, result, now);
    EXPECT_EQ(subscription_.state(), Subscription::State::kActive);
    EXPECT_EQ(subscription_.raw_refusal(), result);
    subscription_.heard(now + 900ms);
    EXPECT_EQ(subscription_.next_due(), now + 1s) << "a third of the lease, as ever";
  }
}

TEST_F(SubscriptionTest, AsksAtOnceThenEvery200Milliseconds) {
  const wire::Subscribe first = asked(kStart);
  EXPECT_EQ(first.cookie, 0U);
  EXPECT_EQ(first.lease_ms, 3000U);
  EXPECT_EQ(subscription_.next_due(), kStart + 200ms);
  EXPECT_TRUE(silent(kStart + 199ms));
  EXPECT_NE(asked(kStart + 200ms).request_id, first.request_id);
  EXPECT_TRUE(silent(kStart + 399ms));
  EXPECT_FALSE(silent(kStart + 400ms));
}

TEST_F(SubscriptionTest, ShowsACookieAtOnceAndRenewsAfterAThirdOfTheLease) {
  reply(asked(kStart), SubscribeResult::kCookie, kStart + 1ms, 99);
  const wire::Subscribe second = asked(kStart + 1ms);
  EXPECT_EQ(second.cookie, 99U);
  reply(second, SubscribeResult::kOk, kStart + 2ms, 100, 1500);
  EXPECT_EQ(subscription_.state(), Subscription::State::kActive);
  EXPECT_TRUE(silent(kStart + 501ms));
  EXPECT_EQ(asked(kStart + 502ms).cookie, 100U);
}

TEST_F(SubscriptionTest, ALostKeepAliveIsRepeatedSoon) {
  join();
  subscription_.heard(kStart + 1s);
  EXPECT_FALSE(silent(kStart + 1s));
  subscription_.heard(kStart + 1200ms);
  EXPECT_TRUE(silent(kStart + 1199ms));
  EXPECT_FALSE(silent(kStart + 1200ms));
  EXPECT_EQ(subscription_.state(), Subscription::State::kActive);
}

// Somebody who replays the sensor's last answer must not keep us from renewing until the lease
// ends.
TEST_F(SubscriptionTest, RoundTripIsTheShortestOfAnsweredRequests) {
  EXPECT_FALSE(subscription_.round_trip());
  const wire::Subscribe first = asked(kStart);
  const wire::Subscribe second = asked(kStart + 200ms);
  reply(first, SubscribeResult::kCookie, kStart + 201ms);
  EXPECT_EQ(subscription_.round_trip(), 201ms);
  reply(second, SubscribeResult::kOk, kStart + 205ms);
  EXPECT_EQ(subscription_.round_trip(), 5ms);
  const Time later = kStart + 205ms + 1s;
  reply(asked(later), SubscribeResult::kOk, later + 3ms);
  EXPECT_EQ(subscription_.round_trip(), 3ms);
  reply(asked(later + 1004ms), SubscribeResult::kOk, later + 1024ms);
  EXPECT_EQ(subscription_.round_trip(), 3ms);
}

TEST_F(SubscriptionTest, ARepeatedAnswerLengthensNothing) {
  const wire::Subscribe first = asked(kStart);
  reply(first, SubscribeResult::kCookie, kStart);
  const wire::Subscribe second = asked(kStart);
  reply(second, SubscribeResult::kOk, kStart);
  for (int at = 1; at < 1000; ++at) {
    const Time now = kStart + std::chrono::milliseconds(at);
    subscription_.heard(now);
    reply(second, SubscribeResult::kOk, now);
    reply(first, SubscribeResult::kCookie, now, 666);
    ASSERT_TRUE(silent(now)) << at;
  }
  EXPECT_EQ(asked(kStart + 1s).cookie, 7U);
}

TEST_F(SubscriptionTest, AnOldCookieIsReplacedWithoutAnInterruption) {
  join();
  const wire::Subscribe late = asked(kStart + 1s);
  reply(late, SubscribeResult::kCookie, kStart + 1s, 55);
  const wire::Subscribe again = asked(kStart + 1s);
  EXPECT_EQ(again.cookie, 55U);
  reply(again, SubscribeResult::kOk, kStart + 1s);
  EXPECT_EQ(subscription_.state(), Subscription::State::kActive);
}

TEST_F(SubscriptionTest, ASensorThatTakesNoCookieDoesNotMakeItSendWithoutEnd) {
  int requests = 0;
  for (Time now = kStart; now < kStart + 1s; now += 1ms) {
    while (const std::optional<Sent> sent = read(subscription_.due(now))) {
      reply(sent->request, SubscribeResult::kCookie, now, static_cast<std::uint64_t>(++requests));
    }
  }
  EXPECT_LE(requests, 10);
  EXPECT_GE(requests, 5);
}

TEST_F(SubscriptionTest, AFullSensorIsAskedOnceASecond) {
  reply(asked(kStart), SubscribeResult::kCookie, kStart);
  reply(asked(kStart), SubscribeResult::kFull, kStart);
  EXPECT_EQ(subscription_.state(), Subscription::State::kFull);
  EXPECT_TRUE(silent(kStart + 999ms));
  reply(asked(kStart + 1s), SubscribeResult::kOk, kStart + 1s);
  EXPECT_EQ(subscription_.state(), Subscription::State::kActive);
}

TEST_F(SubscriptionTest, BeginsAnewWhenNothingWasHeardForHalfASecond) {
  Subscription patient({.lease = 9s}, 1);
  const auto take = [&](SubscribeResult result, Time now) {
    const std::optional<Sent> sent = read(patient.due(now));
    ASSERT_TRUE(sent);
    EXPECT_TRUE(patient.take(
        answer({.request_id = sent->request.request_id, .result = result, .lease_ms = 9000}), now));
  };
  take(SubscribeResult::kOk, kStart);
  patient.heard(kStart + 1500ms);
  EXPECT_TRUE(patient.due(kStart + 1999ms).empty());
  EXPECT_EQ(patient.next_due(), kStart + 2000ms);
  EXPECT_FALSE(patient.due(kStart + 2000ms).empty());
  EXPECT_EQ(patient.state(), Subscription::State::kAsking);
  EXPECT_FALSE(patient.due(kStart + 2200ms).empty());
}

TEST_F(SubscriptionTest, LeavesStreamsAndDamageToOthers) {
  asked(kStart);
  EXPECT_FALSE(subscription_.take({}, kStart));
  EXPECT_FALSE(subscription_.take(test::sealed(PacketType::kTile, Bytes(40)), kStart));
  Bytes damaged = answer({.request_id = 0xFFFFFFFF});
  damaged.back() ^= std::byte{1};
  EXPECT_FALSE(subscription_.take(damaged, kStart));
  EXPECT_EQ(subscription_.state(), Subscription::State::kAsking);
}

TEST_F(SubscriptionTest, IgnoresAnswersToNobodysRequests) {
  const wire::Subscribe request = asked(kStart);
  for (const std::uint32_t other : {request.request_id + 1, request.request_id - 8}) {
    EXPECT_TRUE(subscription_.take(
        answer({.request_id = other, .result = SubscribeResult::kOk, .lease_ms = 3000}), kStart));
    EXPECT_EQ(subscription_.state(), Subscription::State::kAsking) << other;
  }
  EXPECT_TRUE(subscription_.take(test::sealed(PacketType::kSubscribed, Bytes(3)), kStart));
  EXPECT_EQ(subscription_.state(), Subscription::State::kAsking);
}

TEST_F(SubscriptionTest, SubscribesAtTheNamedDeviceOnly) {
  Subscription named({.device_id = 0x52}, 1);
  std::optional<Sent> sent = read(named.due(kStart));
  ASSERT_TRUE(sent);
  EXPECT_EQ(sent->device_id, 0U) << "without a cookie any sensor may say who it is";
  EXPECT_EQ(sent->request.cookie, 0U);
  wire::Subscribed ok{.request_id = 2, .result = SubscribeResult::kOk, .lease_ms = 3000};
  EXPECT_TRUE(named.take(answer(ok, 0x51), kStart));
  EXPECT_EQ(named.state(), Subscription::State::kAsking);
  EXPECT_EQ(named.other_sensor(), 0x51U);
  EXPECT_TRUE(named.take(
      answer({.request_id = 2, .result = SubscribeResult::kCookie, .cookie = 9}, 0x52), kStart));
  sent = read(named.due(kStart));
  ASSERT_TRUE(sent);
  EXPECT_EQ(sent->device_id, 0x52U);
  ok.request_id = 3;
  EXPECT_TRUE(named.take(answer(ok, 0x52), kStart));
  EXPECT_EQ(named.state(), Subscription::State::kActive);
  EXPECT_FALSE(named.other_sensor());
}

TEST_F(SubscriptionTest, SaysFarewellOnlyWhereItIsKnown) {
  EXPECT_TRUE(subscription_.farewell().empty());
  join();
  const std::optional<Sent> sent = read(subscription_.farewell());
  ASSERT_TRUE(sent);
  EXPECT_EQ(sent->type, PacketType::kUnsubscribe);
  EXPECT_EQ(sent->request.cookie, 7U);
}

// A call, as Receiver::next() makes it: what is due goes out, what came is read, what is due again.
TEST_F(SubscriptionTest, ACallEverySecondIsEnough) {
  join();
  Time until = kStart + 3s;
  std::vector<wire::Subscribe> in_flight;
  for (Time now = kStart + 1s; now < kStart + 100s; now += 1s) {
    ASSERT_LT(now, until);
    for (int i = 0; i < 2; ++i) {
      if (const std::optional<Sent> sent = read(subscription_.due(now))) {
        until = now + 3s;
        in_flight.push_back(sent->request);  // answered before the next call
      }
      if (i == 0) {
        for (const wire::Subscribe& request : std::exchange(in_flight, {})) {
          reply(request, SubscribeResult::kOk, now);
        }
      }
    }
  }
}

// Half of all requests and answers get lost.
TEST_F(SubscriptionTest, KeepsALeaseThroughHeavyLoss) {
  Time until = kStart;
  bool interrupted = false;
  std::uint32_t coin = 1;
  const auto arrives = [&] { return ((coin = coin * 1664525U + 1013904223U) >> 31U) != 0; };
  for (Time now = kStart; now < kStart + 600s; now += 10ms) {
    subscription_.heard(now);
    const std::optional<Sent> sent = read(subscription_.due(now));
    if (sent && arrives()) {
      until = now + 3s;
      if (arrives()) {
        reply(sent->request, SubscribeResult::kOk, now);
      }
    }
    interrupted = interrupted || (now > kStart + 5s && now > until);
  }
  EXPECT_FALSE(interrupted);
}

}  // namespace
}  // namespace stof::client
