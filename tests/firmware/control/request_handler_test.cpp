#include "firmware/control/request_handler.h"

#include <gtest/gtest.h>

#include "tests/firmware/control/handler_parts.h"
#include "tests/firmware/control/requests.h"

namespace stof::test {
namespace {

using namespace std::chrono_literals;
using firmware::CookieSecret;
using firmware::LeaseTable;
using firmware::RequestHandler;
using firmware::SettingsService;
using wire::PacketType;
using wire::SettingsResult;
using wire::SubscribeResult;

constexpr std::uint32_t kDevice = 0x0a0b0c0d;

// Answers every request with its text in capitals, or with all the room there is.
class Echo final : public SettingsService {
 public:
  wire::SettingsAnswer serve(const wire::SettingsRequest& request, std::span<const std::byte> text,
                             const firmware::Requester& /*by*/, std::span<std::byte> answer_text,
                             std::size_t& answer_bytes) noexcept override {
    ++served;
    last = request;
    EXPECT_EQ(answer_text.size(), firmware::kSettingsTextBytes);
    answer_bytes = fill ? answer_text.size() + 5 : text.size();
    for (std::size_t i = 0; i < std::min(answer_bytes, answer_text.size()); ++i) {
      answer_text[i] = fill ? std::byte{'f'} : text[i] & std::byte{0xDF};
    }
    return {.result = SettingsResult::kOk, .restart = 1, .total = 7, .revision = 9};
  }

  int served = 0;
  bool fill = false;
  wire::SettingsRequest last;
};

class RequestHandlerTest : public testing::Test {
 protected:
  std::uint64_t cookie_for(const hal::Peer& from) {
    return subscribed(handler_.take(subscribe({.request_id = 1}), from, kStart)).value().cookie;
  }
  wire::Subscribed join(const hal::Peer& from, std::uint16_t lease_ms = 0) {
    const std::uint64_t cookie = cookie_for(from);
    return subscribed(
               handler_.take(subscribe({.request_id = 2, .lease_ms = lease_ms, .cookie = cookie}),
                             from, kStart))
        .value();
  }

  LeaseTable subscribers_;
  Echo echo_;
  RequestHandler handler_{
      {.device_id = kDevice, .session_id = 77}, CookieSecret{}, subscribers_, &echo_};
};

TEST_F(RequestHandlerTest, FirstAsksForACookieThenSubscribes) {
  const std::span<const std::byte> first =
      handler_.take(subscribe({.request_id = 5}), peer(1), kStart);
  const auto header = wire::parse_packet(first);
  ASSERT_TRUE(header);
  EXPECT_EQ(header->header.origin.device_id, kDevice);
  EXPECT_EQ(header->header.origin.session_id, 77U);
  const auto cookie = subscribed(first);
  ASSERT_TRUE(cookie);
  EXPECT_EQ(cookie->result, SubscribeResult::kCookie);
  EXPECT_EQ(cookie->request_id, 5U);
  EXPECT_NE(cookie->cookie, 0U);
  EXPECT_EQ(subscribers_.count(), 0U);

  const auto second = subscribed(
      handler_.take(subscribe({.request_id = 6, .cookie = cookie->cookie}), peer(1), kStart));
  ASSERT_TRUE(second);
  EXPECT_EQ(second->result, SubscribeResult::kOk);
  EXPECT_EQ(second->request_id, 6U);
  EXPECT_EQ(second->subscribers, 1U);
  EXPECT_EQ(second->lease_ms, 3000U);
  EXPECT_EQ(subscribers_.count(), 1U);
  EXPECT_EQ(handler_.counters().cookies, 1U);
  EXPECT_EQ(handler_.counters().accepted, 1U);
}

TEST_F(RequestHandlerTest, TheAnswersCookieKeepsASubscriptionAliveForHours) {
  std::uint64_t cookie = join(peer(1)).cookie;
  for (hal::Time now = kStart; now < kStart + 3h; now += 10s) {
    const auto answer =
        subscribed(handler_.take(subscribe({.lease_ms = 10'000, .cookie = cookie}), peer(1), now));
    ASSERT_TRUE(answer);
    ASSERT_EQ(answer->result, SubscribeResult::kOk);
    cookie = answer->cookie;
  }
}

TEST_F(RequestHandlerTest, TheFifthIsToldThatItIsFullAndComesInWhenALeaseHasEnded) {
  for (std::uint8_t i = 1; i <= 4; ++i) {
    EXPECT_EQ(join(peer(i), i == 2 ? 1000 : 3000).result, SubscribeResult::kOk);
  }
  const wire::Subscribed fifth = join(peer(5));
  EXPECT_EQ(fifth.result, SubscribeResult::kFull);
  EXPECT_EQ(fifth.subscribers, 4U);
  EXPECT_EQ(fifth.lease_ms, 0U);
  const auto again =
      subscribed(handler_.take(subscribe({.cookie = fifth.cookie}), peer(5), kStart + 1s));
  EXPECT_EQ(again.value().result, SubscribeResult::kOk);
}

TEST_F(RequestHandlerTest, UnsubscribingNeedsACookieToo) {
  const std::uint64_t cookie = join(peer(1)).cookie;
  const auto forged = subscribed(
      handler_.take(subscribe({.cookie = cookie + 1}, PacketType::kUnsubscribe), peer(1), kStart));
  EXPECT_EQ(forged.value().result, SubscribeResult::kCookie);
  EXPECT_EQ(subscribers_.count(), 1U);
  const auto own = subscribed(
      handler_.take(subscribe({.cookie = cookie}, PacketType::kUnsubscribe), peer(1), kStart));
  EXPECT_EQ(own.value().result, SubscribeResult::kEnded);
  EXPECT_EQ(own.value().subscribers, 0U);
  EXPECT_EQ(subscribers_.count(), 0U);
}

TEST_F(RequestHandlerTest, CookiesOfOthersOfThePastAndInventedOnesOpenNothing) {
  const std::uint64_t cookie = cookie_for(peer(1));
  for (const hal::Peer& other : {peer(2), peer(1, 5001)}) {
    EXPECT_EQ(
        subscribed(handler_.take(subscribe({.cookie = cookie}), other, kStart)).value().result,
        SubscribeResult::kCookie);
  }
  EXPECT_EQ(
      subscribed(handler_.take(subscribe({.cookie = ~cookie}), peer(1), kStart)).value().result,
      SubscribeResult::kCookie);
  EXPECT_EQ(subscribed(handler_.take(subscribe({.cookie = cookie}), peer(1), kStart + 32s))
                .value()
                .result,
            SubscribeResult::kCookie);
  EXPECT_EQ(subscribers_.count(), 0U);
}

TEST_F(RequestHandlerTest, SettingsAreServedWithACookieOnly) {
  const auto first =
      settings_reply(handler_.take(settings({.request_id = 3}, "abc"), peer(1), kStart));
  ASSERT_TRUE(first);
  EXPECT_EQ(first->answer.result, SettingsResult::kCookie);
  EXPECT_EQ(first->answer.request_id, 3U);
  EXPECT_EQ(first->text, "");
  EXPECT_EQ(echo_.served, 0);

  const auto second =
      settings_reply(handler_.take(settings({.request_id = 4,
                                             .operation = wire::SettingsOperation::kSet,
                                             .offset = 5,
                                             .cookie = first->answer.cookie},
                                            "abc"),
                                   peer(1), kStart));
  ASSERT_TRUE(second);
  EXPECT_EQ(echo_.served, 1);
  EXPECT_EQ(echo_.last.operation, wire::SettingsOperation::kSet);
  EXPECT_EQ(echo_.last.offset, 5U);
  EXPECT_EQ(second->text, "ABC");
  EXPECT_EQ(second->answer.request_id, 4U);
  EXPECT_EQ(second->answer.revision, 9U);
  EXPECT_EQ(second->answer.cookie, first->answer.cookie);
}

TEST_F(RequestHandlerTest, AnAnswerOfSettingsFillsADatagramAndNoMore) {
  echo_.fill = true;
  const std::uint64_t cookie = cookie_for(peer(1));
  const std::span<const std::byte> answer =
      handler_.take(settings({.cookie = cookie}), peer(1), kStart);
  EXPECT_EQ(answer.size(), wire::kMaxDatagram);
  EXPECT_EQ(settings_reply(answer).value().text.size(), firmware::kSettingsTextBytes);
}

TEST_F(RequestHandlerTest, WithoutAServiceSettingsAreUnsupported) {
  RequestHandler bare({.device_id = kDevice}, CookieSecret{}, subscribers_, nullptr);
  const std::uint64_t cookie = cookie_for(peer(1));  // the secrets are equal
  const auto answer = settings_reply(bare.take(settings({.cookie = cookie}), peer(1), kStart));
  EXPECT_EQ(answer.value().answer.result, SettingsResult::kUnsupported);
}

TEST_F(RequestHandlerTest, DiscoverIsAnsweredWithTheAnnounce) {
  EXPECT_EQ(join(peer(1)).result, SubscribeResult::kOk);
  handler_.set_announce({.port = 7560, .serial = {'S', '1'}}, wire::Health::kDegraded);
  const auto packet = wire::parse_packet(handler_.take(discover(42), peer(2), kStart));
  ASSERT_TRUE(packet);
  EXPECT_EQ(packet->header.type, PacketType::kAnnounce);
  EXPECT_EQ(packet->header.frame.health, wire::Health::kDegraded);
  const Result<wire::Announce> announce = wire::decode_announce(packet->payload);
  ASSERT_TRUE(announce);
  EXPECT_EQ(announce->request_id, 42U);
  EXPECT_EQ(announce->port, 7560U);
  EXPECT_EQ(announce->serial[1], '1');
  EXPECT_EQ(announce->subscribers, 1U);
  EXPECT_EQ(announce->most_subscribers, 4U);
}

TEST_F(RequestHandlerTest, RequestsForAnotherDeviceAreNotOurs) {
  EXPECT_TRUE(
      handler_.take(subscribe({}, PacketType::kSubscribe, kDevice + 1), peer(1), kStart).empty());
  EXPECT_EQ(handler_.counters().foreign, 1U);
  EXPECT_FALSE(
      handler_.take(subscribe({}, PacketType::kSubscribe, kDevice), peer(1), kStart).empty());
}

TEST_F(RequestHandlerTest, CountsEveryRefusalByItsReason) {
  const Bytes good = subscribe({});
  const auto refused = [&](Bytes bytes) {
    EXPECT_TRUE(handler_.take(bytes, peer(1), kStart).empty());
    return handler_.counters();
  };
  EXPECT_EQ(refused({}).truncated, 1U);
  EXPECT_EQ(refused({good.begin(), good.end() - 1}).truncated, 2U);
  const auto changed = [&](std::size_t at) {
    Bytes bytes = good;
    bytes[at] ^= std::byte{0x40};
    return bytes;
  };
  EXPECT_EQ(refused(changed(0)).bad_magic, 1U);
  EXPECT_EQ(refused(changed(4)).bad_version, 1U);
  Bytes longer = good;
  longer.push_back({});
  EXPECT_EQ(refused(longer).bad_length, 1U);
  EXPECT_EQ(refused(changed(60)).bad_crc, 1U);
  handler_.take_oversized();
  EXPECT_EQ(handler_.counters().bad_length, 2U);
  for (const PacketType type :
       {PacketType::kTile, PacketType::kFrameInfo, PacketType::kCalibration, PacketType::kHealth,
        PacketType::kSubscribed, PacketType::kSettingsAnswer, PacketType::kAnnounce,
        static_cast<PacketType>(131), static_cast<PacketType>(255)}) {
    EXPECT_TRUE(handler_.take(sealed(type, good), peer(1), kStart).empty());
  }
  EXPECT_EQ(handler_.counters().not_control, 9U);
  const Bytes half(wire::kSubscribeBytes - 1);
  EXPECT_EQ(refused(sealed(PacketType::kSubscribe, half)).bad_field, 1U);
  EXPECT_EQ(handler_.counters().accepted + handler_.counters().cookies, 0U);
}

}  // namespace
}  // namespace stof::test
