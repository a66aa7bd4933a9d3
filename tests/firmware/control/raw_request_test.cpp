#include <gtest/gtest.h>

#include "firmware/control/request_handler.h"
#include "firmware/wire/frame/raw_packets.h"
#include "tests/firmware/control/handler_parts.h"
#include "tests/firmware/control/requests.h"
#include "tests/firmware/keys/signed_requests.h"
#include "tests/firmware/keys/some_keys.h"

namespace stof::test {
namespace {

using namespace std::chrono_literals;
using firmware::CookieSecret;
using firmware::kMostSubscribers;
using firmware::LeaseTable;
using firmware::ReceiverList;
using wire::PacketType;
using wire::SubscribeResult;

constexpr wire::RawRequest kAll{.pictures = wire::kRawPictures, .every = 3};

// Who asks for raw pictures, and gets them.
class RawRequestTest : public testing::Test {
 protected:
  void SetUp() override { ASSERT_TRUE(wire::start_crypto()); }
  wire::Subscribe asked(const hal::Peer& from, const wire::RawRequest& raw,
                        std::uint16_t lease_ms) const {
    return {.request_id = 5,
            .lease_ms = lease_ms,
            .cookie = firmware::Cookies(CookieSecret{}).make(from, now_),
            .raw = raw};
  }
  SubscribeResult plain(const hal::Peer& from, const wire::RawRequest& raw,
                        PacketType type = PacketType::kSubscribe, std::uint16_t lease_ms = 3000) {
    return subscribed(handler_.take(subscribe(asked(from, raw, lease_ms), type), from, now_))
        .value()
        .result;
  }
  SubscribeResult sign(const wire::Key& key, const hal::Peer& from, const wire::RawRequest& raw,
                       PacketType type = PacketType::kSubscribe) {
    const Bytes request = signed_subscribe(key, kHere, ++counter_, asked(from, raw, 3000), type);
    const std::span<const std::byte> answer = handler_.take(request, from, now_);
    const auto view = wire::open_signed(wire::parse_packet(answer).value(), answer);
    // Whatever becomes of them, the streams come, and are signed.
    EXPECT_NE(wire::decode_stream_key_fields(view->payload.subspan(wire::kSubscribedBytes))->number,
              0U);
    return wire::decode_subscribed(view->payload)->result;
  }
  // Whom the loop sends them to.
  std::optional<hal::Peer> receiver() {
    const ReceiverList list = subscribers_.list();
    return list.raw_receiver < list.count ? std::optional(list.peers.at(list.raw_receiver))
                                          : std::nullopt;
  }
  void pair() {
    ASSERT_EQ(ring_.add(viewer_), Status::kOk);
    ASSERT_EQ(ring_.add(admin_), Status::kOk);
  }

  wire::Key viewer_ = numbered_key(11, wire::Role::kView);
  wire::Key admin_ = numbered_key(12, wire::Role::kAdmin);
  hal::Time now_{1'000'000s};
  std::uint64_t counter_ = 100;
  keys::Keyring ring_{nullptr, nullptr};
  keys::Authenticator authenticator_{ring_};
  LeaseTable subscribers_;
  firmware::RequestHandler handler_{kHere, CookieSecret{}, subscribers_, nullptr, &authenticator_};
};

TEST_F(RawRequestTest, NobodyHasThemUnasked) {
  EXPECT_EQ(plain(peer(1), {}), SubscribeResult::kOk);
  EXPECT_EQ(plain(peer(2), {.pictures = wire::kRawWhole, .every = 1}), SubscribeResult::kOk);
  EXPECT_EQ(receiver(), std::nullopt);
  EXPECT_EQ(subscribers_.list().raw_receiver, kMostSubscribers);
}

TEST_F(RawRequestTest, WithoutACookieNothingIsAskedFor) {
  const auto answer =
      subscribed(handler_.take(subscribe({.request_id = 1, .raw = kAll}), peer(1), now_));
  ASSERT_TRUE(answer);
  EXPECT_EQ(answer->result, SubscribeResult::kCookie);
  EXPECT_EQ(receiver(), std::nullopt);
}

TEST_F(RawRequestTest, OfAnUnpairedSensorWhoeverAsksFirstHasThem) {
  EXPECT_EQ(plain(peer(1), {}), SubscribeResult::kOk);
  EXPECT_EQ(plain(peer(2), kAll), SubscribeResult::kOk);
  EXPECT_EQ(receiver(), peer(2));
  EXPECT_EQ(subscribers_.list().raw, kAll);
  EXPECT_EQ(plain(peer(3), kAll), SubscribeResult::kRawTaken);
  EXPECT_EQ(subscribers_.count(), 3U) << "its streams come";
  EXPECT_EQ(receiver(), peer(2));
}

TEST_F(RawRequestTest, EachSubscribeSaysAnewWhichOnes) {
  EXPECT_EQ(plain(peer(1), kAll), SubscribeResult::kOk);
  const ReceiverList before = subscribers_.list();
  EXPECT_EQ(plain(peer(1), {.pictures = 0xE1, .step = 2}), SubscribeResult::kOk);
  EXPECT_EQ(subscribers_.list().raw.pictures, wire::kRawLeft) << "the rest has no meaning yet";
  EXPECT_EQ(subscribers_.list().raw.step, 2);
  EXPECT_FALSE(subscribers_.list() == before) << "the loop would not be told";
  EXPECT_EQ(plain(peer(1), {.pictures = wire::kRawLeft | wire::kRawAnew}), SubscribeResult::kOk);
  EXPECT_EQ(subscribers_.list().raw.pictures, wire::kRawLeft | wire::kRawAnew);
  EXPECT_EQ(plain(peer(1), {}), SubscribeResult::kOk);
  EXPECT_EQ(receiver(), std::nullopt);
  EXPECT_EQ(plain(peer(2), kAll), SubscribeResult::kOk) << "they are free again";
}

TEST_F(RawRequestTest, TheyEndWithTheLease) {
  EXPECT_EQ(plain(peer(1), kAll, PacketType::kSubscribe, 500), SubscribeResult::kOk);
  EXPECT_EQ(plain(peer(2), kAll), SubscribeResult::kRawTaken);
  now_ += 499ms;
  subscribers_.expire(now_);
  EXPECT_EQ(receiver(), peer(1));
  now_ += 1ms;
  EXPECT_EQ(plain(peer(2), kAll), SubscribeResult::kOk);
  EXPECT_EQ(receiver(), peer(2));
  EXPECT_EQ(plain(peer(2), kAll, PacketType::kUnsubscribe), SubscribeResult::kEnded);
  EXPECT_EQ(receiver(), std::nullopt);
}

TEST_F(RawRequestTest, TheyStayWithTheirReceiverWhenOneBeforeItLeaves) {
  EXPECT_EQ(plain(peer(1), {}), SubscribeResult::kOk);
  EXPECT_EQ(plain(peer(2), kAll), SubscribeResult::kOk);
  EXPECT_EQ(plain(peer(1), {}, PacketType::kUnsubscribe), SubscribeResult::kEnded);
  EXPECT_EQ(receiver(), peer(2));
  EXPECT_EQ(subscribers_.list().raw_receiver, 0U);
}

TEST_F(RawRequestTest, OfAPairedSensorTheyTakeAKeyOfAnyRole) {
  pair();
  EXPECT_EQ(plain(peer(1), kAll), SubscribeResult::kRawDenied);
  EXPECT_EQ(subscribers_.count(), 1U) << "its streams come";
  EXPECT_EQ(receiver(), std::nullopt);
  EXPECT_EQ(sign(viewer_, peer(2), kAll), SubscribeResult::kOk);
  EXPECT_EQ(receiver(), peer(2));
  EXPECT_EQ(sign(admin_, peer(3), kAll), SubscribeResult::kRawTaken) << "first come";
}

TEST_F(RawRequestTest, AKeyTakesThemFromWhoHasNone) {
  EXPECT_EQ(plain(peer(1), kAll), SubscribeResult::kOk);
  pair();
  EXPECT_EQ(sign(viewer_, peer(2), kAll), SubscribeResult::kOk);
  EXPECT_EQ(receiver(), peer(2));
  EXPECT_EQ(plain(peer(1), kAll), SubscribeResult::kRawDenied);
  EXPECT_EQ(receiver(), peer(2));
}

TEST_F(RawRequestTest, WhoHadThemBeforeThereWasAKeyLosesThemWithTheNextRequest) {
  EXPECT_EQ(plain(peer(1), kAll), SubscribeResult::kOk);
  pair();
  EXPECT_EQ(plain(peer(1), kAll), SubscribeResult::kRawDenied);
  EXPECT_EQ(receiver(), std::nullopt);
}

TEST_F(RawRequestTest, NoUnsignedRequestChangesWhatASignedOneAskedFor) {
  pair();
  EXPECT_EQ(sign(viewer_, peer(2), kAll), SubscribeResult::kOk);
  EXPECT_EQ(plain(peer(2), {}), SubscribeResult::kOk);
  EXPECT_EQ(plain(peer(2), {.pictures = 1}), SubscribeResult::kRawDenied);
  EXPECT_EQ(subscribers_.list().raw, kAll);
  EXPECT_EQ(sign(viewer_, peer(2), {}), SubscribeResult::kOk);
  EXPECT_EQ(receiver(), std::nullopt);
}

TEST_F(RawRequestTest, AKeyThatIsEndedTakesThemAlong) {
  pair();
  EXPECT_TRUE(subscribers_.fix(peer(2)));  // a fixed destination stays
  EXPECT_EQ(sign(viewer_, peer(2), kAll), SubscribeResult::kOk);
  ASSERT_EQ(ring_.remove(viewer_.id), Status::kOk);
  EXPECT_EQ(plain(peer(3), {}), SubscribeResult::kOk);
  EXPECT_EQ(receiver(), std::nullopt);
  EXPECT_EQ(subscribers_.count(), 2U);
}

TEST_F(RawRequestTest, WhereTheInstallerFixedTheStreamsTheyTakeAnAdmin) {
  subscribers_.keep_raw_for_admins(true);
  EXPECT_EQ(plain(peer(1), kAll), SubscribeResult::kRawDenied) << "unpaired as well";
  pair();
  EXPECT_EQ(sign(viewer_, peer(2), kAll), SubscribeResult::kRawDenied);
  EXPECT_EQ(receiver(), std::nullopt);
  EXPECT_EQ(sign(admin_, peer(3), kAll), SubscribeResult::kOk);
  EXPECT_EQ(receiver(), peer(3));
}

TEST_F(RawRequestTest, WhereNobodyKnowsTheKeysNobodyHasThem) {
  firmware::RequestHandler alone(kHere, CookieSecret{}, subscribers_, nullptr);
  const auto answer = subscribed(alone.take(subscribe(asked(peer(1), kAll, 3000)), peer(1), now_));
  ASSERT_TRUE(answer);
  EXPECT_EQ(answer->result, SubscribeResult::kRawDenied);
}

}  // namespace
}  // namespace stof::test
