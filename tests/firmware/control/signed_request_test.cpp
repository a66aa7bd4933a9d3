#include <gtest/gtest.h>

#include "firmware/control/request_handler.h"
#include "firmware/wire/bytes.h"
#include "firmware/wire/crc32c.h"
#include "tests/firmware/control/handler_parts.h"
#include "tests/firmware/keys/signed_requests.h"
#include "tests/firmware/keys/some_keys.h"
#include "tests/support/random.h"

namespace stof::test {
namespace {

using namespace std::chrono_literals;
using firmware::Access;
using firmware::CookieSecret;
using firmware::RequestHandler;
using wire::PacketType;
using wire::Role;
using wire::SettingsResult;

class SignedRequestTest : public testing::Test {
 protected:
  void SetUp() override {
    ASSERT_TRUE(wire::start_crypto());
    ASSERT_EQ(ring_.add(admin_), Status::kOk);
    ASSERT_EQ(ring_.add(tune_), Status::kOk);
    ASSERT_EQ(ring_.add(view_), Status::kOk);
    cookie_ = firmware::Cookies(CookieSecret{}).make(robot_, kStart);
  }
  Bytes request(const wire::Key& key, std::uint64_t counter, std::string_view text = "abc") {
    return signed_settings(
        key, kHere, counter,
        {.request_id = 5, .operation = wire::SettingsOperation::kSet, .cookie = cookie_}, text);
  }
  std::span<const std::byte> take(const Bytes& datagram) {
    return handler_.take(datagram, robot_, now_);
  }

  wire::Key admin_ = numbered_key(11, Role::kAdmin);
  wire::Key tune_ = numbered_key(12, Role::kTune);
  wire::Key view_ = numbered_key(13, Role::kView);
  hal::Peer robot_ = peer(1);
  hal::Time now_ = kStart;
  std::uint64_t cookie_ = 0;
  keys::Keyring ring_{nullptr, nullptr};
  keys::Authenticator authenticator_{ring_};
  firmware::LeaseTable subscribers_;
  NotingSettings settings_;
  RequestHandler handler_{kHere, CookieSecret{}, subscribers_, &settings_, &authenticator_};
};

TEST_F(SignedRequestTest, IsServedWithTheRoleOfItsKeyAndTheAnswerIsSignedToo) {
  const std::array expected{std::pair(&admin_, Access::kAdmin), std::pair(&tune_, Access::kTune),
                            std::pair(&view_, Access::kRead)};
  std::uint64_t counter = 100;
  for (const auto& [key, access] : expected) {
    const auto reply = signed_reply(*key, take(request(*key, ++counter)));
    ASSERT_TRUE(reply.has_value());
    EXPECT_EQ(settings_.last.access, access);
    EXPECT_EQ(reply->fields.key_id, key->id);
    EXPECT_EQ(reply->fields.counter, counter);
    EXPECT_EQ(reply->fields.highest, counter);
    EXPECT_EQ(reply->answer.request_id, 5U);
    EXPECT_EQ(reply->answer.revision, 9U);
    EXPECT_NE(reply->answer.cookie, 0U);
    EXPECT_EQ(reply->text, "abc");
  }
  EXPECT_EQ(handler_.counters().accepted, 3U);
}

TEST_F(SignedRequestTest, AnAnswerThatIsTooLongIsCutOff) {
  settings_.fill = true;
  const auto reply = signed_reply(admin_, take(request(admin_, 1)));
  ASSERT_TRUE(reply.has_value());
  EXPECT_EQ(reply->text.size(), wire::kMaxSignedPayload - wire::kSettingsAnswerBytes);
}

TEST_F(SignedRequestTest, WhatIsNotSignedChangesNothingOnAPairedSensor) {
  const wire::SettingsRequest plain{.request_id = 5, .cookie = cookie_};
  ASSERT_TRUE(settings_reply(take(settings(plain))).has_value());
  EXPECT_EQ(settings_.last.access, Access::kRead);
  for (const wire::Key& key : {admin_, tune_, view_}) {
    ASSERT_EQ(ring_.remove(key.id), Status::kOk);
  }
  ASSERT_TRUE(settings_reply(take(settings(plain))).has_value());
  EXPECT_EQ(settings_.last.access, Access::kHarmless);  // unpaired
  RequestHandler without(kHere, CookieSecret{}, subscribers_, &settings_);
  ASSERT_TRUE(settings_reply(without.take(settings(plain), robot_, now_)).has_value());
  EXPECT_EQ(settings_.last.access, Access::kRead);
}

TEST_F(SignedRequestTest, ReplaysAndReordersAreRefusedAndTheSignerIsTold) {
  const Bytes first = request(admin_, 10);
  const Bytes second = request(admin_, 11);
  ASSERT_TRUE(signed_reply(admin_, take(second)).has_value());
  for (const Bytes& old : {first, second, request(admin_, 11, "else"), request(admin_, 0)}) {
    const auto reply = signed_reply(admin_, take(old));
    ASSERT_TRUE(reply.has_value());
    EXPECT_EQ(reply->answer.result, SettingsResult::kStale);
    EXPECT_EQ(reply->fields.highest, 11U);
    EXPECT_EQ(reply->text, "");
  }
  EXPECT_EQ(settings_.served, 1);
  EXPECT_EQ(handler_.counters().replayed, 4U);
  // The counters of keys are their own.
  EXPECT_EQ(signed_reply(tune_, take(request(tune_, 1)))->answer.result, SettingsResult::kOk);
  EXPECT_EQ(signed_reply(admin_, take(request(admin_, 12)))->answer.result, SettingsResult::kOk);
}

TEST_F(SignedRequestTest, AnotherKeyOrNoneIsRefusedWithoutASignature) {
  wire::Key other = numbered_key(99);
  for (const std::uint32_t id : {other.id, admin_.id}) {
    other.id = id;
    const auto reply = settings_reply(take(request(other, 50)));
    ASSERT_TRUE(reply.has_value());
    EXPECT_EQ(reply->answer.result, SettingsResult::kUnknownKey);
    EXPECT_EQ(reply->answer.request_id, 5U);
  }
  EXPECT_EQ(settings_.served, 0);
  EXPECT_EQ(handler_.counters().forged, 2U);
  // A forged counter is not noted.
  EXPECT_TRUE(signed_reply(admin_, take(request(admin_, 1))).has_value());
}

// Judging costs little, answering three times that.
TEST_F(SignedRequestTest, WhoeverGuessesOrRepeatsIsToldSeldom) {
  const wire::Key other = numbered_key(99);
  const Bytes old = request(admin_, 7);
  ASSERT_TRUE(signed_reply(admin_, take(old)).has_value());
  constexpr int kTries = 500;
  int told = 0;
  for (int i = 0; i < kTries; ++i) {
    told += take(i % 2 == 0 ? old : request(other, 50)).empty() ? 0 : 1;
  }
  EXPECT_GE(told, static_cast<int>(firmware::RequestLimits::kRefusedPerHost));
  EXPECT_LE(told, static_cast<int>(firmware::RequestLimits::kRefusedPerHost) + 1);
  EXPECT_EQ(handler_.counters().replayed, 250U);
  EXPECT_EQ(handler_.counters().forged, 250U);
  // Who has a key is served meanwhile, from the same host.
  EXPECT_EQ(signed_reply(admin_, take(request(admin_, 8)))->answer.result, SettingsResult::kOk);
}

TEST_F(SignedRequestTest, AKeyThatWasRemovedOrReplacedIsNoKeyAtOnce) {
  ASSERT_TRUE(signed_reply(tune_, take(request(tune_, 1))).has_value());
  ASSERT_EQ(ring_.remove(tune_.id), Status::kOk);
  EXPECT_EQ(settings_reply(take(request(tune_, 2)))->answer.result, SettingsResult::kUnknownKey);
  ASSERT_EQ(ring_.replace(admin_.id, numbered_key(5).secret, keys::Shown::kFormer), Status::kOk);
  // Until the new secret has signed, the one of before holds: its owner may not have the new one.
  EXPECT_EQ(signed_reply(admin_, take(request(admin_, 2)))->answer.result, SettingsResult::kOk);
  EXPECT_EQ(signed_reply(admin_, take(request(admin_, 2)))->answer.result, SettingsResult::kStale);
  wire::Key renewed = admin_;
  renewed.secret = numbered_key(5).secret;
  EXPECT_TRUE(signed_reply(renewed, take(request(renewed, 3))).has_value());
  EXPECT_EQ(settings_reply(take(request(admin_, 4)))->answer.result, SettingsResult::kUnknownKey);
  EXPECT_TRUE(signed_reply(renewed, take(request(renewed, 4))).has_value());
}

TEST_F(SignedRequestTest, ManyKeysComeAndGoAndEachHasACounter) {
  for (std::uint32_t id = 100; id < 200; ++id) {
    const wire::Key key = numbered_key(id);
    now_ += 100ms;  // not more refusals than a host is told of
    ASSERT_EQ(ring_.add(key), Status::kOk);
    ASSERT_TRUE(signed_reply(key, take(request(key, 7))).has_value());
    const auto repeated = signed_reply(key, take(request(key, 7)));
    ASSERT_TRUE(repeated.has_value()) << id;
    EXPECT_EQ(repeated->answer.result, SettingsResult::kStale);
    if (ring_.keys().count() == keys::kMostKeys) {
      ASSERT_EQ(ring_.remove(ring_.keys().all()[3].id), Status::kOk);
    }
  }
}

TEST_F(SignedRequestTest, TheCookieAndTheSessionComeFirst) {
  const auto refused = [this](const Bytes& datagram) {
    const auto reply = settings_reply(take(datagram));
    return reply && reply->answer.result == SettingsResult::kCookie && reply->answer.cookie != 0;
  };
  const wire::SettingsRequest without{.request_id = 5};
  EXPECT_TRUE(refused(signed_settings(admin_, kHere, 1, without)));
  const wire::SettingsRequest with{.request_id = 5, .cookie = cookie_};
  for (const std::uint32_t session : {0U, 76U, 78U}) {
    EXPECT_TRUE(refused(signed_settings(admin_, {.device_id = 1, .session_id = session}, 1, with)));
  }
  EXPECT_TRUE(take(signed_settings(admin_, {.device_id = 2, .session_id = 77}, 1, with)).empty());
  now_ += 40s;  // the cookie is too old: what was held back is worth nothing
  EXPECT_TRUE(refused(request(admin_, 1)));
  EXPECT_EQ(settings_.served, 0);
  EXPECT_EQ(handler_.counters().forged, 0U);
}

TEST_F(SignedRequestTest, WhatIsTooShortOrOfAnotherMessageIsRefused) {
  const Bytes good = request(admin_, 1, "");
  for (std::size_t cut = 0; cut <= good.size(); ++cut) {
    ASSERT_TRUE(
        take(Bytes(good.begin(), good.begin() + static_cast<std::ptrdiff_t>(cut))).empty() ||
        cut == good.size());
  }
  for (std::size_t bytes = 0;
       bytes < wire::kSignedFieldsBytes + sizeof(wire::Tag) + wire::kSettingsRequestBytes;
       ++bytes) {
    ASSERT_TRUE(take(sealed(PacketType::kSignedRequest, Bytes(bytes))).empty()) << bytes;
  }
  EXPECT_EQ(settings_.served, 1);
}

TEST_F(SignedRequestTest, AHostHasItsShareBeforeAnythingIsComputed) {
  for (std::uint64_t i = 0; i < 2 * firmware::RequestLimits::kProvenPerHost; ++i) {
    static_cast<void>(take(request(numbered_key(99), i)));
  }
  EXPECT_EQ(handler_.counters().forged, firmware::RequestLimits::kProvenPerHost);
  EXPECT_EQ(handler_.counters().busy, firmware::RequestLimits::kProvenPerHost);
}

// What somebody has who listens on the network and sends in the robot's name: captured requests,
// one of them kept from the sensor. Of what he makes of them the check sum is right.
class Attacker {
 public:
  void capture(const Bytes& datagram) { captured_.push_back(datagram); }

  Bytes attempt(int kind) {
    Bytes packet = any();
    switch (kind % 4) {
      case 0:
        return captured_[random_.next() % (captured_.size() - 1)];  // again, but the one kept back
      case 1:
        for (int flips = 0; flips <= kind % 3; ++flips) {
          packet[random_.next() % (packet.size() - wire::kCrcBytes)] ^=
              static_cast<std::byte>(1U << random_.next() % 8);
        }
        break;
      case 2: {  // a part of another one
        const Bytes other = any();
        const std::size_t most = std::min(packet.size(), other.size()) - wire::kCrcBytes;
        const std::size_t first = wire::kHeaderBytes + random_.next() % (most - wire::kHeaderBytes);
        std::copy(other.begin() + static_cast<std::ptrdiff_t>(first),
                  other.begin() + static_cast<std::ptrdiff_t>(most),
                  packet.begin() + static_cast<std::ptrdiff_t>(first));
        break;
      }
      default:  // a guessed tag, a counter above all
        wire::put_u64(std::span(packet).subspan(wire::kHeaderBytes + 8).first<8>(),
                      ~std::uint64_t{0} - random_.next() % 1000);
        for (std::size_t k = 0; k < sizeof(wire::Tag); ++k) {
          packet[packet.size() - wire::kCrcBytes - 1 - k] = static_cast<std::byte>(random_.next());
        }
    }
    const std::size_t end = packet.size() - wire::kCrcBytes;
    wire::put_u32(std::span(packet).last<4>(), wire::crc32c(std::span(packet).first(end)));
    return std::ranges::find(captured_, packet) == captured_.end() ? packet : captured_.front();
  }

 private:
  const Bytes& any() { return captured_[random_.next() % captured_.size()]; }

  Random random_{2026};
  std::vector<Bytes> captured_;
};

TEST_F(SignedRequestTest, OfAMillionForgedRequestsNoneIsServed) {
  constexpr int kTriesOfACookie = 10'000;  // one a millisecond, as many as a host is heard with
  constexpr int kTries = 1'000'000;
  std::uint64_t counter = 0;
  int served = 0;
  for (int block = 0; block < kTries / kTriesOfACookie; ++block) {
    now_ += 1s;
    cookie_ = firmware::Cookies(CookieSecret{}).make(robot_, now_);
    Attacker attacker;
    for (std::size_t i = 0; i < 20; ++i) {
      const Bytes datagram =
          request(i % 2 == 0 ? admin_ : tune_, ++counter, std::string(1 + i, 'x'));
      attacker.capture(datagram);
      ASSERT_FALSE(take(datagram).empty());
      ++served;
    }
    attacker.capture(request(admin_, ++counter, "kept back"));
    for (int i = 0; i < kTriesOfACookie; ++i) {
      now_ += 1ms;
      static_cast<void>(take(attacker.attempt(i)));
      ASSERT_EQ(settings_.served, served) << block << " " << i;
    }
  }
  const wire::ControlCounters counters = handler_.counters();
  EXPECT_GT(counters.forged, std::uint64_t{kTries} / 2);
  EXPECT_GT(counters.replayed, std::uint64_t{kTries} / 5);
  EXPECT_LT(counters.busy, std::uint64_t{kTries} / 100);
}

}  // namespace
}  // namespace stof::test
