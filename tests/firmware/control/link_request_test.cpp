// Requests by broadcast, of hosts that have no address of the sensor's network: who may what is the
// same as by any other way.
#include <gtest/gtest.h>

#include "firmware/control/request_handler.h"
#include "tests/firmware/control/handler_parts.h"
#include "tests/firmware/keys/signed_requests.h"
#include "tests/firmware/keys/some_keys.h"

namespace stof::test {
namespace {

using namespace std::chrono_literals;
using firmware::Access;
using firmware::CookieSecret;
using firmware::RequestHandler;
using wire::Role;
using wire::SettingsResult;

hal::Peer over_link(const hal::Peer& peer, std::uint32_t interface = 2) {
  hal::Peer link = peer;
  link.scope = interface;
  return link;
}

class LinkRequestTest : public testing::Test {
 protected:
  void SetUp() override {
    ASSERT_TRUE(wire::start_crypto());
    ASSERT_EQ(ring_.add(admin_), Status::kOk);
  }
  static std::uint64_t cookie_of(const hal::Peer& peer) {
    return firmware::Cookies(CookieSecret{}).make(peer, kStart);
  }
  Bytes request(std::uint64_t counter, const hal::Peer& from) const {
    return signed_settings(
        admin_, kHere, counter,
        {.request_id = 5, .operation = wire::SettingsOperation::kSet, .cookie = cookie_of(from)},
        R"({"network": {"dhcp": true}})");
  }
  static Bytes plain(const hal::Peer& from, std::uint32_t device) {
    const Bytes request = settings(
        {.request_id = 5, .operation = wire::SettingsOperation::kSet, .cookie = cookie_of(from)},
        std::string(40, ' '));
    const auto packet = wire::parse_packet(request);
    return sealed(wire::PacketType::kSettingsRequest, packet->payload, device);
  }
  std::span<const std::byte> take(const Bytes& datagram, const hal::Peer& from) {
    return handler_.take(datagram, from, now_);
  }

  wire::Key admin_ = numbered_key(11, Role::kAdmin);
  hal::Peer host_ = peer(1, firmware::kLinkPort);
  hal::Peer link_ = over_link(host_);
  hal::Time now_ = kStart;
  keys::Keyring ring_{nullptr, nullptr};
  keys::Authenticator authenticator_{ring_};
  firmware::LeaseTable subscribers_;
  NotingSettings settings_;
  RequestHandler handler_{kHere, CookieSecret{}, subscribers_, &settings_, &authenticator_};
};

TEST_F(LinkRequestTest, WhoHasTheKeyIsServedAndAnswered) {
  const auto reply = signed_reply(admin_, take(request(1, link_), link_));
  ASSERT_TRUE(reply);
  EXPECT_EQ(reply->answer.result, SettingsResult::kOk);
  EXPECT_EQ(settings_.last.access, Access::kAdmin);
  EXPECT_EQ(settings_.last.key_id, admin_.id);
  // Whatever address it says that it has, nobody has proven it.
  ASSERT_TRUE(settings_.last.peer);
  EXPECT_EQ(settings_.last.peer->address, hal::kAllOfLink);
}

TEST_F(LinkRequestTest, WithoutAKeyNothingIsChanged) {
  const auto reply = settings_reply(take(plain(link_, kHere.device_id), link_));
  ASSERT_TRUE(reply);
  EXPECT_EQ(settings_.last.access, Access::kRead);
}

TEST_F(LinkRequestTest, WhatIsForgedOrRepeatedDoesNothing) {
  const Bytes good = request(7, link_);
  ASSERT_FALSE(take(good, link_).empty());
  const auto again = signed_reply(admin_, take(good, link_));
  ASSERT_TRUE(again);
  EXPECT_EQ(again->answer.result, SettingsResult::kStale);
  wire::Key forged = admin_;
  forged.secret = numbered_key(12).secret;
  const Bytes wrong =
      signed_settings(forged, kHere, 8, {.request_id = 6, .cookie = cookie_of(link_)});
  const auto told = settings_reply(take(wrong, link_));
  ASSERT_TRUE(told);
  EXPECT_EQ(told->answer.result, SettingsResult::kUnknownKey);
  EXPECT_EQ(settings_.served, 1);
  // What the whole link has heard is good for nothing by the other way.
  EXPECT_EQ(signed_reply(admin_, take(good, host_)), std::nullopt);
  EXPECT_EQ(settings_.served, 1);
}

// The whole link hears it, and would have itself served in that host's name.
TEST_F(LinkRequestTest, ACookieOfOneWayIsNoneOfTheOther) {
  EXPECT_NE(cookie_of(link_), cookie_of(host_));
  EXPECT_NE(cookie_of(link_), cookie_of(over_link(host_, 3)));
  const std::uint64_t heard =
      settings_reply(take(settings({.request_id = 1}), host_)).value().answer.cookie;
  EXPECT_EQ(heard, cookie_of(host_));
  const auto answer =
      subscribed(take(subscribe({.request_id = 2, .cookie = cookie_of(link_)}), host_));
  ASSERT_TRUE(answer);
  EXPECT_EQ(answer->result, wire::SubscribeResult::kCookie);
  EXPECT_EQ(subscribers_.count(), 0U);
}

TEST_F(LinkRequestTest, NobodySubscribesALink) {
  EXPECT_TRUE(take(subscribe({.request_id = 2, .cookie = cookie_of(link_)},
                             wire::PacketType::kSubscribe, kHere.device_id),
                   link_)
                  .empty());
  EXPECT_TRUE(
      take(signed_subscribe(admin_, kHere, 3, {.request_id = 2, .cookie = cookie_of(link_)}), link_)
          .empty());
  EXPECT_EQ(subscribers_.count(), 0U);
}

TEST_F(LinkRequestTest, OnlyADiscoverMayBeForAnySensor) {
  EXPECT_TRUE(take(plain(link_, 0), link_).empty());
  EXPECT_TRUE(take(plain(link_, kHere.device_id + 1), link_).empty());
  EXPECT_FALSE(take(discover(4), link_).empty());
}

TEST_F(LinkRequestTest, AllHostsOfItTogetherAreAnsweredTwentyTimesASecond) {
  int answers = 0;
  int proven = 0;
  for (int i = 0; i < 10'000; ++i) {
    now_ += 1ms;
    const hal::Peer from = over_link(peer(static_cast<std::uint8_t>(i % 200), firmware::kLinkPort));
    answers += take(discover(4), from).empty() ? 0 : 1;
    proven += take(plain(from, kHere.device_id), from).empty() ? 0 : 1;
  }
  EXPECT_LE(answers, 10 * 20 + 20);
  EXPECT_LE(proven, 10 * 20 + 20);
  EXPECT_GE(answers, 10 * 20 - 20);
  EXPECT_LE(settings_.served, 10 * 20 + 20);
  // It took nothing of what those hosts have by their own addresses.
  EXPECT_FALSE(take(discover(4), host_).empty());
}

TEST_F(LinkRequestTest, AnswersNobodyUnprovenWithMoreThanItSent) {
  for (std::size_t size = 0; size < 200; ++size) {
    now_ += 1s;
    for (int type = 0; type < 256; ++type) {
      const Bytes asked = sealed(static_cast<wire::PacketType>(type), Bytes(size), kHere.device_id);
      EXPECT_LE(take(asked, link_).size(), asked.size()) << type << " " << size;
    }
  }
}

}  // namespace
}  // namespace stof::test
