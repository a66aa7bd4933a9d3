#include <gtest/gtest.h>

#include "firmware/control/request_handler.h"
#include "firmware/serial/line/serial_request_handler.h"
#include "tests/firmware/control/handler_parts.h"
#include "tests/firmware/keys/pairing_client.h"
#include "tests/firmware/keys/signed_requests.h"
#include "tests/firmware/keys/some_keys.h"

namespace stof::test {
namespace {

using namespace std::chrono_literals;
using firmware::CookieSecret;
using firmware::RequestHandler;
using firmware::SerialRequestHandler;
using keys::Shown;
using wire::PairMethod;
using wire::PairRequest;
using wire::PairResult;
using wire::Role;
using wire::SettingsResult;

Bytes packet(const wire::PairRequest& request) {
  std::array<std::byte, wire::kPairRequestBytes> payload;
  wire::encode_pair_request(request, payload);
  return sealed(wire::PacketType::kPairRequest, payload);
}

std::optional<wire::PairAnswer> answer_in(std::span<const std::byte> datagram) {
  const auto parsed = wire::parse_packet(datagram);
  if (!parsed || parsed->header.type != wire::PacketType::kPairAnswer) {
    return std::nullopt;
  }
  const auto answer = wire::decode_pair_answer(parsed->payload);
  return answer ? std::optional(*answer) : std::nullopt;
}

class PairRequestTest : public testing::Test {
 protected:
  void SetUp() override {
    ASSERT_TRUE(wire::start_crypto());
    handler_.set_pairing(&pairing_);
    line_.set_pairing(&pairing_);
  }
  std::optional<wire::PairAnswer> over_network(wire::PairRequest request) {
    request.cookie = firmware::Cookies(CookieSecret{}).make(peer(1), kStart);
    return answer_in(handler_.take(packet(request), peer(1), kStart));
  }
  std::optional<wire::PairAnswer> over_line(const wire::PairRequest& request) {
    return answer_in(line_.take(packet(request), kStart));
  }

  NotingSettings settings_;
  keys::Keyring ring_{nullptr, nullptr};
  keys::Authenticator authenticator_{ring_};
  keys::PairingServer pairing_{kHere, ring_, std::nullopt};
  firmware::LeaseTable subscribers_;
  RequestHandler handler_{kHere, CookieSecret{}, subscribers_, &settings_, &authenticator_};
  SerialRequestHandler line_{kHere, &settings_, &handler_};
};

TEST_F(PairRequestTest, WithoutACookieNothingBegins) {
  pairing_.open(kStart);
  PairingClient client(kHere, PairMethod::kDigits, Role::kAdmin);
  const Bytes request = packet(client.begin());
  const auto datagram = handler_.take(request, peer(1), kStart);
  EXPECT_LE(datagram.size(), request.size());
  const auto answer = answer_in(datagram);
  ASSERT_TRUE(answer.has_value());
  EXPECT_EQ(answer->result, PairResult::kCookie);
  EXPECT_NE(answer->cookie, 0U);
  EXPECT_EQ(answer->attempt, 0U);
}

TEST_F(PairRequestTest, TheCableIsTheCableAndTheNetworkIsNot) {
  PairingClient client(kHere, PairMethod::kCable, Role::kAdmin);
  EXPECT_EQ(over_network(client.begin())->result, PairResult::kClosed);
  const auto begun = over_line(client.begin());
  ASSERT_TRUE(begun.has_value());
  ASSERT_EQ(over_line(client.reveal(*begun))->result, PairResult::kOk);
  EXPECT_EQ(over_line(client.confirm())->result, PairResult::kOk);
  EXPECT_EQ(ring_.keys().count(), 1U);
}

TEST_F(PairRequestTest, OnlyTheCableOpensAndAcceptsForOthers) {
  PairingClient holder(kHere, PairMethod::kDigits, Role::kAdmin);
  EXPECT_EQ(over_network(holder.open())->result, PairResult::kClosed);
  line_.set_remote(true);
  EXPECT_FALSE(over_line(holder.open()).has_value());
  EXPECT_FALSE(pairing_.is_open());

  line_.set_remote(false);
  EXPECT_EQ(over_line(holder.open())->result, PairResult::kOk);
  EXPECT_TRUE(pairing_.is_open());
  PairingClient client(kHere, PairMethod::kDigits, Role::kTune);
  const auto begun = over_network(client.begin());
  ASSERT_EQ(over_network(client.reveal(*begun))->result, PairResult::kOk);
  ASSERT_EQ(over_network(client.confirm())->result, PairResult::kWaiting);
  const PairRequest accept = holder.accept(client.secrets().digits());
  EXPECT_EQ(over_network(accept)->result, PairResult::kClosed);
  line_.set_remote(true);
  EXPECT_FALSE(over_line(accept).has_value());
  EXPECT_EQ(ring_.keys().count(), 0U);
  line_.set_remote(false);
  EXPECT_EQ(over_line(accept)->result, PairResult::kOk);
  EXPECT_EQ(over_network(client.confirm())->result, PairResult::kOk);
  EXPECT_EQ(ring_.keys().count(), 1U);
}

TEST_F(PairRequestTest, ARemoteLineNeverPairs) {
  line_.set_remote(true);
  pairing_.open(kStart);
  for (const PairMethod method : {PairMethod::kCable, PairMethod::kDigits}) {
    PairingClient client(kHere, method, Role::kAdmin);
    EXPECT_FALSE(over_line(client.begin()).has_value());
  }
  EXPECT_EQ(ring_.keys().count(), 0U);
}

// So a renewal over the cable ends the old secret at once.
TEST_F(PairRequestTest, ALocalLineJudgesWhatAKeySignsByThatKey) {
  wire::Key key = numbered_key(3, Role::kTune);
  ASSERT_EQ(ring_.add(key), Status::kOk);
  ASSERT_EQ(ring_.replace(3, numbered_key(4).secret, Shown::kFormer), Status::kOk);
  key.secret = numbered_key(4).secret;
  const wire::SettingsRequest asked{.request_id = 1,
                                    .cookie = firmware::Cookies(CookieSecret{}).make({}, kStart)};
  const auto unproven = settings_reply(line_.take(signed_settings(key, kHere, 1, {}), kStart));
  ASSERT_TRUE(unproven.has_value());
  EXPECT_EQ(unproven->answer.result, SettingsResult::kCookie);
  EXPECT_TRUE(signed_reply(key, line_.take(signed_settings(key, kHere, 1, asked), kStart)));
  EXPECT_EQ(settings_.last.access, firmware::Access::kTune);
  EXPECT_FALSE(ring_.keys().find(3)->former.has_value());
}

TEST_F(PairRequestTest, ARemoteLineTakesKeysAsTheNetworkDoes) {
  const wire::Key key = numbered_key(3, Role::kTune);
  ASSERT_EQ(ring_.add(key), Status::kOk);
  // On a cable no key is asked for.
  ASSERT_TRUE(settings_reply(line_.take(settings({.request_id = 1}), kStart)).has_value());
  EXPECT_EQ(settings_.last.access, firmware::Access::kAdmin);

  line_.set_remote(true);
  const auto asked = settings_reply(line_.take(settings({.request_id = 2}), kStart));
  ASSERT_TRUE(asked.has_value());
  EXPECT_EQ(asked->answer.result, SettingsResult::kCookie);
  const wire::SettingsRequest with{.request_id = 3, .cookie = asked->answer.cookie};
  ASSERT_TRUE(settings_reply(line_.take(settings(with), kStart)).has_value());
  EXPECT_EQ(settings_.last.access, firmware::Access::kRead);
  ASSERT_TRUE(signed_reply(key, line_.take(signed_settings(key, kHere, 1, with), kStart)));
  EXPECT_EQ(settings_.last.access, firmware::Access::kTune);
  const auto again = signed_reply(key, line_.take(signed_settings(key, kHere, 1, with), kStart));
  ASSERT_TRUE(again.has_value());
  EXPECT_EQ(again->answer.result, SettingsResult::kStale);
  // Nobody subscribes there.
  EXPECT_TRUE(line_.take(subscribe({.cookie = asked->answer.cookie}), kStart).empty());
  EXPECT_EQ(subscribers_.count(), 0U);
  // A cookie of the line is none of the network's.
  EXPECT_EQ(settings_reply(handler_.take(settings(with), peer(1), kStart))->answer.result,
            SettingsResult::kCookie);
}

}  // namespace
}  // namespace stof::test
