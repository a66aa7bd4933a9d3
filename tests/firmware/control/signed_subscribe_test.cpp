#include <gtest/gtest.h>

#include "firmware/control/request_handler.h"
#include "tests/firmware/control/handler_parts.h"
#include "tests/firmware/keys/signed_requests.h"
#include "tests/firmware/keys/some_keys.h"

namespace stof::test {
namespace {

using namespace std::chrono_literals;
using firmware::CookieSecret;
using firmware::LeaseTable;
using wire::PacketType;
using wire::SubscribeResult;

// What a signed answer said.
struct Reply {
  wire::Subscribed subscribed;
  wire::StreamKey stream;
};

class SignedSubscribeTest : public testing::Test {
 protected:
  void SetUp() override {
    ASSERT_TRUE(wire::start_crypto());
    ASSERT_EQ(ring_.add(key_), Status::kOk);
    ASSERT_EQ(ring_.add(other_), Status::kOk);
  }
  std::uint64_t cookie(const hal::Peer& from) const {
    return firmware::Cookies(CookieSecret{}).make(from, now_);
  }
  Bytes request(const wire::Key& key, const hal::Peer& from, std::uint32_t has = 0,
                PacketType type = PacketType::kSubscribe) {
    return signed_subscribe(
        key, kHere, ++counter_,
        {.request_id = 5, .lease_ms = 3000, .cookie = cookie(from), .stream_key = has}, type);
  }
  std::optional<Reply> ask(const wire::Key& key, const hal::Peer& from, std::uint32_t has = 0,
                           PacketType type = PacketType::kSubscribe) {
    return read(key, handler_.take(request(key, from, has, type), from, now_));
  }
  static std::optional<Reply> read(const wire::Key& key, std::span<const std::byte> datagram) {
    const auto packet = wire::parse_packet(datagram);
    if (!packet || packet->header.type != PacketType::kSignedAnswer) {
      return std::nullopt;
    }
    const auto view = wire::open_signed(*packet, datagram);
    if (!view || !wire::signed_with(key.secret, *view) ||
        view->fields.type != static_cast<std::uint8_t>(PacketType::kSubscribed)) {
      return std::nullopt;
    }
    Reply reply{.subscribed = *wire::decode_subscribed(view->payload), .stream = {}};
    const auto fields =
        wire::decode_stream_key_fields(view->payload.subspan(wire::kSubscribedBytes));
    if (fields && fields->number != 0) {
      reply.stream = wire::open_stream_key(
          *fields, {.sensor = kHere, .key = key, .counter = view->fields.counter});
    }
    return reply;
  }
  std::optional<SubscribeResult> plain(const hal::Peer& from,
                                       PacketType type = PacketType::kSubscribe) {
    const auto answer = subscribed(
        handler_.take(subscribe({.lease_ms = 3000, .cookie = cookie(from)}, type), from, now_));
    return answer ? std::optional(answer->result) : std::nullopt;
  }
  wire::StreamKey key_of(std::size_t receiver) const { return subscribers_.list().keys[receiver]; }

  wire::Key key_ = numbered_key(11, wire::Role::kView);
  wire::Key other_ = numbered_key(12, wire::Role::kAdmin);
  hal::Peer robot_ = peer(1);
  hal::Time now_ = kStart;
  std::uint64_t counter_ = 100;
  keys::Keyring ring_{nullptr, nullptr};
  keys::Authenticator authenticator_{ring_};
  LeaseTable subscribers_;
  firmware::RequestHandler handler_{kHere, CookieSecret{}, subscribers_, nullptr, &authenticator_};
};

TEST_F(SignedSubscribeTest, BringsAStreamKeyOfThisReceiverAlone) {
  const auto first = ask(key_, robot_);
  ASSERT_TRUE(first.has_value());
  EXPECT_EQ(first->subscribed.result, SubscribeResult::kOk);
  EXPECT_EQ(first->subscribed.lease_ms, 3000U);
  ASSERT_NE(first->stream.number, 0U);
  EXPECT_EQ(key_of(0), first->stream);
  const auto second = ask(other_, peer(2));
  const auto third = ask(key_, peer(1, 5001));  // the same key, another receiver
  ASSERT_TRUE(second && third);
  EXPECT_NE(second->stream.secret, first->stream.secret);
  EXPECT_NE(third->stream.secret, first->stream.secret);
  EXPECT_NE(third->stream.number, first->stream.number);
}

TEST_F(SignedSubscribeTest, RenewingGoesOnWithTheKeyAndTellsItAgain) {
  const auto first = ask(key_, robot_);
  ASSERT_TRUE(first);
  for (int i = 0; i < 5; ++i) {
    now_ += 1s;
    const auto again = ask(key_, robot_, first->stream.number);
    ASSERT_TRUE(again);
    EXPECT_EQ(again->stream, first->stream);
  }
  EXPECT_EQ(subscribers_.count(), 1U);
}

TEST_F(SignedSubscribeTest, WhoeverHasNoneOrAnotherNumberGetsANewOne) {
  const auto first = ask(key_, robot_);
  const auto lost = ask(key_, robot_);  // the answer before was lost
  ASSERT_TRUE(first && lost);
  EXPECT_GT(lost->stream.number, first->stream.number);
  const auto wrong = ask(key_, robot_, first->stream.number);
  ASSERT_TRUE(wrong);
  EXPECT_GT(wrong->stream.number, lost->stream.number);
  // With another key of the sensor: whoever has the one before knows nothing of it.
  const auto rolled = ask(other_, robot_, wrong->stream.number);
  ASSERT_TRUE(rolled);
  EXPECT_GT(rolled->stream.number, wrong->stream.number);
  EXPECT_EQ(key_of(0), rolled->stream);
  // After the end of the lease as well.
  now_ += 4s;
  const auto later = ask(other_, robot_, rolled->stream.number);
  ASSERT_TRUE(later);
  EXPECT_GT(later->stream.number, rolled->stream.number);
}

TEST_F(SignedSubscribeTest, WithoutACookieOrInAnotherSessionItOnlyGetsOne) {
  wire::Subscribe asked{.request_id = 5};
  Bytes bytes = signed_subscribe(key_, kHere, ++counter_, asked, PacketType::kSubscribe);
  auto answer = subscribed(handler_.take(bytes, robot_, now_));
  ASSERT_TRUE(answer);
  EXPECT_EQ(answer->result, SubscribeResult::kCookie);
  asked.cookie = cookie(robot_);
  bytes = signed_subscribe(key_, {.device_id = 1, .session_id = 76}, ++counter_, asked,
                           PacketType::kSubscribe);
  answer = subscribed(handler_.take(bytes, robot_, now_));
  ASSERT_TRUE(answer);
  EXPECT_EQ(answer->result, SubscribeResult::kCookie);
  EXPECT_EQ(subscribers_.count(), 0U);
}

TEST_F(SignedSubscribeTest, ReplayedForgedAndUnknownSubscribeNobody) {
  const Bytes captured = request(key_, robot_);
  ASSERT_TRUE(read(key_, handler_.take(captured, robot_, now_)));
  const wire::StreamKey before = key_of(0);
  const auto stale = read(key_, handler_.take(captured, robot_, now_));
  ASSERT_TRUE(stale);
  EXPECT_EQ(stale->subscribed.result, SubscribeResult::kStale);
  EXPECT_EQ(stale->stream.number, 0U);
  wire::Key unknown = numbered_key(99);
  const auto refused = subscribed(handler_.take(request(unknown, peer(2)), peer(2), now_));
  ASSERT_TRUE(refused);
  EXPECT_EQ(refused->result, SubscribeResult::kUnknownKey);
  unknown.id = key_.id;
  EXPECT_EQ(subscribed(handler_.take(request(unknown, peer(2)), peer(2), now_))->result,
            SubscribeResult::kUnknownKey);
  EXPECT_EQ(subscribers_.count(), 1U);
  EXPECT_EQ(key_of(0), before);
  EXPECT_EQ(handler_.counters().forged, 2U);
  EXPECT_EQ(handler_.counters().replayed, 1U);
}

TEST_F(SignedSubscribeTest, NobodyWithoutAKeyEndsItOrItsSigning) {
  const auto first = ask(key_, robot_);
  ASSERT_TRUE(first);
  EXPECT_EQ(plain(robot_), SubscribeResult::kOk);
  EXPECT_EQ(key_of(0), first->stream);
  EXPECT_EQ(plain(robot_, PacketType::kUnsubscribe), SubscribeResult::kEnded);
  EXPECT_EQ(subscribers_.count(), 1U);
  ASSERT_TRUE(ask(key_, robot_, 0, PacketType::kUnsubscribe));
  EXPECT_EQ(subscribers_.count(), 0U);
}

TEST_F(SignedSubscribeTest, ASerialLineIsNoReceiver) {
  const hal::Peer line{};
  EXPECT_TRUE(handler_.take(request(key_, line), line, now_).empty());
  EXPECT_EQ(subscribers_.count(), 0U);
  EXPECT_EQ(handler_.counters().bad_field, 1U);
}

TEST_F(SignedSubscribeTest, OnePlaceIsKeptForWhoeverHasAKey) {
  for (std::uint8_t host = 2; host <= 4; ++host) {
    EXPECT_EQ(plain(peer(host)), SubscribeResult::kOk);
  }
  EXPECT_EQ(plain(peer(5)), SubscribeResult::kFull);
  const auto robot = ask(key_, robot_);
  ASSERT_TRUE(robot);
  EXPECT_EQ(robot->subscribed.result, SubscribeResult::kOk);
  EXPECT_EQ(plain(peer(3)), SubscribeResult::kOk) << "renews";
  const auto full = ask(other_, peer(6));
  ASSERT_TRUE(full);
  EXPECT_EQ(full->subscribed.result, SubscribeResult::kFull);
  EXPECT_EQ(full->stream.number, 0U);
}

TEST_F(SignedSubscribeTest, AHostThatFloodsDoesNotKeepItsOwnKeyHolderOut) {
  for (std::uint16_t port = 1; port <= 3; ++port) {
    EXPECT_EQ(plain(peer(1, port)), SubscribeResult::kOk);
  }
  EXPECT_EQ(plain(peer(1, 4)), SubscribeResult::kFull);
  const auto robot = ask(key_, robot_);
  ASSERT_TRUE(robot);
  EXPECT_EQ(robot->subscribed.result, SubscribeResult::kOk);
}

TEST_F(SignedSubscribeTest, WhoHadTheKeptPlaceBeforeThereWasAKeyLosesItWithItsLease) {
  ASSERT_EQ(ring_.remove(key_.id), Status::kOk);
  ASSERT_EQ(ring_.remove(other_.id), Status::kOk);
  for (std::uint8_t host = 2; host <= 5; ++host) {
    EXPECT_EQ(plain(peer(host)), SubscribeResult::kOk);
  }
  ASSERT_EQ(ring_.add(key_), Status::kOk);
  EXPECT_EQ(plain(peer(2)), SubscribeResult::kOk);
  EXPECT_EQ(plain(peer(5)), SubscribeResult::kFull) << "the last that came";
  now_ += 2s;
  for (std::uint8_t host = 2; host <= 4; ++host) {
    EXPECT_EQ(plain(peer(host)), SubscribeResult::kOk);
  }
  now_ += 2s;
  const auto robot = ask(key_, robot_);
  ASSERT_TRUE(robot);
  EXPECT_EQ(robot->subscribed.result, SubscribeResult::kOk);
}

TEST_F(SignedSubscribeTest, AKeyThatWasEndedKeepsNoPlaceAndNoSigning) {
  ASSERT_TRUE(ask(key_, robot_));
  for (std::uint8_t host = 2; host <= 4; ++host) {
    EXPECT_EQ(plain(peer(host)), SubscribeResult::kOk);
  }
  ASSERT_EQ(ring_.remove(key_.id), Status::kOk);
  EXPECT_EQ(plain(robot_), SubscribeResult::kFull) << "the place is for who has a key";
  EXPECT_EQ(subscribers_.count(), 3U);
  const auto owner = ask(other_, peer(6));
  ASSERT_TRUE(owner);
  EXPECT_EQ(owner->subscribed.result, SubscribeResult::kOk);
  EXPECT_EQ(plain(peer(4), PacketType::kUnsubscribe), SubscribeResult::kEnded);
  EXPECT_EQ(plain(robot_), SubscribeResult::kOk);
  EXPECT_EQ(key_of(3).number, 0U) << "as everybody";
}

TEST_F(SignedSubscribeTest, AKeyThatWasRenewedKeepsItsPlaceAndItsStreamKey) {
  const auto first = ask(key_, robot_);
  ASSERT_TRUE(first);
  ASSERT_EQ(ring_.replace(key_.id, numbered_key(13).secret, keys::Shown::kFormer), Status::kOk);
  EXPECT_EQ(plain(robot_), SubscribeResult::kOk);
  EXPECT_EQ(key_of(0), first->stream);
}

}  // namespace
}  // namespace stof::test
