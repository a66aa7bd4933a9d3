#include <algorithm>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "firmware/control/request_handler.h"
#include "firmware/wire/keys/signed_packet.h"
#include "host/client/control/subscription.h"
#include "host/client/session/stream_verifier.h"
#include "tests/firmware/control/requests.h"
#include "tests/firmware/keys/some_keys.h"

// Subscriptions to signed streams, against the appliance's own handler.
namespace stof::client {
namespace {

using namespace std::chrono_literals;
using test::Bytes;
using test::numbered_key;
using wire::SubscribeResult;
using State = Subscription::State;

constexpr std::uint32_t kSensor = 1;  // of numbered_key()
constexpr Time kSubscribed{1000s};

SubscriptionOptions with(std::initializer_list<wire::Key> keys) {
  SubscriptionOptions options{.signed_streams = true};
  for (const wire::Key& key : keys) {
    EXPECT_EQ(options.keys.add(key), Status::kOk);
  }
  return options;
}

class SignedSubscription : public testing::Test {
 protected:
  void SetUp() override {
    ASSERT_TRUE(wire::start_crypto());
    ASSERT_EQ(ring_.add(key_), Status::kOk);
    start(7);
  }
  void start(std::uint32_t session) {
    subscribers_ = {};
    authenticator_.emplace(ring_);
    handler_.emplace(wire::Origin{.device_id = kSensor, .session_id = session},
                     firmware::CookieSecret{static_cast<std::byte>(session)}, subscribers_, nullptr,
                     &*authenticator_);
  }
  // What the sensor answers to what is due; empty: nothing was.
  Bytes answer_due(Subscription& subscription) {
    const auto request = subscription.due(now_);
    if (request.empty()) {
      return {};
    }
    const auto answer = handler_->take(request, test::peer(1), hal::Time(now_.time_since_epoch()));
    return {answer.begin(), answer.end()};
  }
  // Turns until nothing is due.
  void talk(Subscription& subscription) {
    for (int i = 0; i < 10; ++i) {
      const Bytes answer = answer_due(subscription);
      if (answer.empty()) {
        return;
      }
      EXPECT_TRUE(subscription.take(answer, now_));
    }
    FAIL() << "it asks without end";
  }
  wire::StreamKey sensors_key() const { return subscribers_.list().keys[0]; }

  wire::Key key_ = numbered_key(4, wire::Role::kView);
  Time now_ = kSubscribed;
  keys::Keyring ring_{nullptr, nullptr};
  firmware::LeaseTable subscribers_;
  std::optional<keys::Authenticator> authenticator_;
  std::optional<firmware::RequestHandler> handler_;
};

// Requests are on their way when the answer to one of before comes.
TEST_F(SignedSubscription, ComesToTheKeyWhereAnswersTakeLongerThanTheNextRequest) {
  for (const Duration way : {90ms, 100ms, 130ms, 300ms, 900ms}) {
    start(7);
    Subscription subscription(with({key_}), 100);
    std::multimap<Time, Bytes> requests;
    std::multimap<Time, Bytes> answers;
    const Time begin = now_;
    std::optional<Duration> active;
    for (; now_ < begin + 10s; now_ += 10ms) {
      if (const auto request = subscription.due(now_); !request.empty()) {
        requests.emplace(now_ + way, Bytes(request.begin(), request.end()));
      }
      for (; !requests.empty() && requests.begin()->first <= now_;
           requests.erase(requests.begin())) {
        const auto answer = handler_->take(requests.begin()->second, test::peer(1),
                                           hal::Time(now_.time_since_epoch()));
        answers.emplace(now_ + way, Bytes(answer.begin(), answer.end()));
      }
      for (; !answers.empty() && answers.begin()->first <= now_; answers.erase(answers.begin())) {
        subscription.take(answers.begin()->second, now_);
      }
      subscription.heard(now_);  // frames
      if (!active && subscription.state() == State::kActive) {
        active = now_ - begin;
      }
    }
    ASSERT_TRUE(active) << way.count();
    EXPECT_LE(*active, 4 * way + 2 * Subscription::kRepeat) << way.count();
    EXPECT_EQ(subscription.round_trip(), 2 * way);
    EXPECT_EQ(subscription.stream_key().number, sensors_key().number);
    EXPECT_TRUE(wire::equal_secrets(subscription.stream_key().secret, sensors_key().secret));
    EXPECT_LE(subscription.key_asked(), begin + *active + 2 * way) << "keys go on being asked for";
  }
}

TEST_F(SignedSubscription, ComesToTheKeyThatTheSensorSignsWith) {
  Subscription subscription(with({key_}), 5);
  talk(subscription);
  EXPECT_EQ(subscription.state(), State::kActive);
  ASSERT_NE(subscription.stream_key().number, 0U);
  EXPECT_EQ(subscription.stream_key(), sensors_key());
}

TEST_F(SignedSubscription, RenewsItsLeaseWithTheSameKey) {
  Subscription subscription(with({key_}), 5);
  talk(subscription);
  const wire::StreamKey first = subscription.stream_key();
  for (int i = 0; i < 40; ++i) {
    now_ += 500ms;
    subscription.heard(now_);
    talk(subscription);
    subscribers_.expire(hal::Time(now_.time_since_epoch()));
    ASSERT_EQ(subscribers_.count(), 1U);
    ASSERT_EQ(subscription.stream_key(), first);
    ASSERT_EQ(sensors_key(), first);
  }
}

// Whoever is faster than the sensor, each time.
TEST_F(SignedSubscription, CookiesOfMadeUpSessionsStarveItNot) {
  Subscription subscription(with({key_}), 100);
  std::uint32_t made_up = 1000;
  for (const Time end = now_ + 2s; now_ < end && subscription.state() != State::kActive;
       now_ += 10ms) {
    const auto request = subscription.due(now_);
    if (request.empty()) {
      continue;
    }
    const auto packet = wire::parse_packet(request);
    const auto view = wire::open_signed(*packet, request);
    const auto asked = wire::decode_subscribe(view ? view->payload : packet->payload);
    ASSERT_TRUE(asked);
    const auto answer = handler_->take(request, test::peer(1), hal::Time(now_.time_since_epoch()));
    Bytes lie(wire::kSubscribedBytes);
    wire::encode_subscribed(
        {.request_id = asked->request_id, .result = SubscribeResult::kCookie, .cookie = ++made_up},
        std::span(lie).first<wire::kSubscribedBytes>());
    subscription.take(test::sealed(wire::PacketType::kSubscribed, lie, kSensor, made_up), now_);
    subscription.take(answer, now_);
  }
  EXPECT_EQ(subscription.state(), State::kActive);
  EXPECT_EQ(subscription.stream_key(), sensors_key());
}

TEST_F(SignedSubscription, ALostAnswerOrCookieCostsARepetition) {
  Subscription subscription(with({key_}), 5);
  static_cast<void>(answer_due(subscription));  // the cookie is lost
  now_ += Subscription::kRepeat;
  EXPECT_TRUE(subscription.take(answer_due(subscription), now_));
  EXPECT_NE(subscription.state(), State::kActive);
  static_cast<void>(answer_due(subscription));  // and the key
  EXPECT_EQ(subscribers_.count(), 1U);
  now_ += Subscription::kRepeat;
  talk(subscription);
  EXPECT_EQ(subscription.state(), State::kActive);
  EXPECT_EQ(subscription.stream_key(), sensors_key());
}

TEST_F(SignedSubscription, ASensorThatStartsAgainGivesAnotherKey) {
  Subscription subscription(with({key_}), 5);
  talk(subscription);
  const wire::StreamKey first = subscription.stream_key();
  start(8);
  now_ += 2s;  // nothing was heard
  talk(subscription);
  EXPECT_EQ(subscription.state(), State::kActive);
  EXPECT_EQ(subscription.stream_key(), sensors_key());
  EXPECT_NE(subscription.stream_key().secret, first.secret);
}

TEST_F(SignedSubscription, WithoutAKeyThatTheSensorHasThereIsNoSubscription) {
  wire::Key elsewhere = key_;
  elsewhere.device = kSensor + 1;
  for (const auto& options : {with({}), with({elsewhere}), with({numbered_key(9)})}) {
    Subscription subscription(options, 5);
    for (int i = 0; i < 30; ++i) {
      talk(subscription);
      now_ += 300ms;
    }
    EXPECT_EQ(subscription.state(), State::kNoKey);
    EXPECT_EQ(subscription.stream_key().number, 0U);
    EXPECT_EQ(subscribers_.count(), 0U) << "and no other instead";
  }
}

TEST_F(SignedSubscription, OfSeveralKeysItFindsTheOneThatTheSensorHas) {
  Subscription subscription(with({key_, numbered_key(8), numbered_key(9)}), 5);
  for (int i = 0; i < 30 && subscription.state() != State::kActive; ++i) {
    talk(subscription);
    now_ += 300ms;
  }
  EXPECT_EQ(subscription.stream_key(), sensors_key());
}

// The user's file has the new secret, and the program that receives goes on.
TEST_F(SignedSubscription, AKeyThatAnotherProgramRenewsGoesOnWithItsNewSecret) {
  wire::KeyTable file = with({key_}).keys;
  int read = 0;
  SubscriptionOptions options = with({key_});
  options.reread = [&]() -> std::optional<wire::KeyTable> {
    ++read;
    return file;
  };
  Subscription subscription(options, 5);
  talk(subscription);
  wire::Key renewed = numbered_key(9, wire::Role::kView);
  renewed.id = key_.id;
  ASSERT_TRUE(ring_.remove(key_.id) == Status::kOk);
  ASSERT_EQ(ring_.add(renewed), Status::kOk);
  ASSERT_TRUE(file.remove(key_.id));
  // Not there yet: nothing comes, and another key of the file is not taken.
  wire::Key other = numbered_key(9, wire::Role::kView);
  other.id = key_.id + 1;
  ASSERT_EQ(file.add(other), Status::kOk);
  for (int i = 0; i < 10; ++i) {
    now_ += 1s;
    talk(subscription);
  }
  EXPECT_EQ(subscription.state(), State::kNoKey);
  EXPECT_GE(read, 5);
  EXPECT_LE(read, 12);
  ASSERT_EQ(file.add(renewed), Status::kOk);
  for (int i = 0; i < 3; ++i) {
    now_ += 1s;
    talk(subscription);
  }
  EXPECT_EQ(subscription.state(), State::kActive);
  EXPECT_EQ(subscription.proven_key(), key_.id);
}

// Whoever sits between can say so; that it goes on is the sensor's matter.
TEST_F(SignedSubscription, AForgedRefusalPassesAndAForgedConsentIsNone) {
  Subscription subscription(with({key_}), 5);
  ASSERT_TRUE(subscription.take(answer_due(subscription), now_));  // the cookie
  std::uint32_t request_id = 0;
  for (const SubscribeResult said :
       {SubscribeResult::kOk, SubscribeResult::kFull, SubscribeResult::kEnded,
        SubscribeResult::kStale, SubscribeResult::kUnknownKey}) {
    now_ += 1s;
    static_cast<void>(answer_due(subscription));
    request_id = 5;  // numbers go up from there
    for (std::uint32_t ahead = 0; ahead < 20; ++ahead) {
      std::array<std::byte, wire::kSubscribedBytes> payload;
      wire::encode_subscribed(
          {.request_id = request_id + ahead, .result = said, .lease_ms = 10'000, .cookie = 1},
          payload);
      static_cast<void>(
          subscription.take(test::sealed(wire::PacketType::kSubscribed, payload, kSensor), now_));
    }
    EXPECT_NE(subscription.state(), State::kActive) << static_cast<int>(said);
    EXPECT_NE(subscription.state(), State::kFull);
    EXPECT_EQ(subscription.stream_key().number, 0U);
  }
  now_ += 2s;
  talk(subscription);
  EXPECT_EQ(subscription.state(), State::kActive);
}

TEST_F(SignedSubscription, AnAnswerToAnEarlierRequestCountsUntilANewerOneCame) {
  Subscription subscription(with({key_}), 5);
  ASSERT_TRUE(subscription.take(answer_due(subscription), now_));
  const Bytes early = answer_due(subscription);
  now_ += Subscription::kRepeat;
  const Bytes now = answer_due(subscription);
  EXPECT_TRUE(subscription.take(early, now_));
  EXPECT_NE(subscription.stream_key().number, 0U);
  EXPECT_NE(subscription.stream_key(), sensors_key());
  EXPECT_TRUE(subscription.take(now, now_));
  EXPECT_EQ(subscription.stream_key(), sensors_key());
  subscription.take(early, now_);
  EXPECT_EQ(subscription.stream_key(), sensors_key());
}

// What it signs was sent after it was asked for.
TEST_F(SignedSubscription, AsksForANewKeyAtOnceAndOnceASecond) {
  Subscription subscription(with({key_}), 5);
  talk(subscription);
  const wire::StreamKey first = subscription.stream_key();
  EXPECT_EQ(subscription.key_asked(), now_);
  for (int i = 0; i < 10; ++i) {
    now_ += 90ms;
    subscription.heard(now_);
    subscription.renew_key(now_);
    talk(subscription);
  }
  const wire::StreamKey second = subscription.stream_key();
  EXPECT_EQ(second.number, first.number + 1);
  EXPECT_EQ(second, sensors_key());
  EXPECT_EQ(subscription.key_asked(), kSubscribed + 90ms);
  now_ += 1s;
  subscription.heard(now_);
  subscription.renew_key(now_);
  static_cast<void>(answer_due(subscription));  // lost
  for (int i = 0; i < 5; ++i) {
    now_ += Subscription::kRepeat;
    subscription.heard(now_);
    talk(subscription);
  }
  EXPECT_EQ(subscription.stream_key().number, second.number + 2);
  EXPECT_EQ(subscription.stream_key(), sensors_key());
  EXPECT_EQ(subscription.key_asked(), now_);
}

// As a sensor of another release answers, which makes tags in another way.
Bytes with_tags(const Bytes& answer, std::uint8_t tags, const wire::Key& key) {
  constexpr std::size_t kTagsAt = 4;  // of the stream key
  const auto packet = wire::parse_packet(answer);
  if (!packet || packet->header.type != wire::PacketType::kSignedAnswer) {
    return answer;
  }
  const auto view = wire::open_signed(*packet, answer);
  EXPECT_TRUE(view);
  wire::DatagramBuffer buffer{};
  const auto space = wire::signed_space(buffer);
  std::ranges::copy(view->payload, space.begin());
  space[wire::kSubscribedBytes + kTagsAt] = std::byte{tags};
  const auto sealed =
      wire::seal_signed(packet->header, view->fields, view->payload.size(), key.secret, buffer);
  return {sealed.begin(), sealed.end()};
}

TEST_F(SignedSubscription, SaysThatTheSensorSignsAsAnotherReleaseUntilItIsUpdated) {
  for (const std::uint8_t tags : {std::uint8_t{0}, std::uint8_t{2}}) {
    Subscription subscription(with({key_}), 5);
    int asked = 0;
    for (int i = 0; i < 40; ++i, now_ += 100ms) {
      const Bytes answer = answer_due(subscription);
      if (!answer.empty()) {
        ++asked;
        EXPECT_TRUE(subscription.take(with_tags(answer, tags, key_), now_));
      }
    }
    EXPECT_EQ(subscription.state(), State::kOtherTags);
    EXPECT_EQ(subscription.other_tags(), tags);
    EXPECT_EQ(subscription.stream_key().number, 0U) << "nothing is verified with it";
    EXPECT_LE(asked, 8) << "once a second";
    const std::string text = other_tags_text(subscription.other_tags());
    EXPECT_NE(text.find(tags == 0 ? "update the sensor" : "update this program"), std::string::npos)
        << text;
    now_ += 1s;
    talk(subscription);
    EXPECT_EQ(subscription.state(), State::kActive);
    EXPECT_EQ(subscription.stream_key(), sensors_key());
    start(8 + tags);  // without its subscribers
  }
}

TEST_F(SignedSubscription, LeavesWithASignature) {
  Subscription subscription(with({key_}), 5);
  talk(subscription);
  ASSERT_EQ(subscribers_.count(), 1U);
  static_cast<void>(
      handler_->take(subscription.farewell(), test::peer(1), hal::Time(now_.time_since_epoch())));
  EXPECT_EQ(subscribers_.count(), 0U);
}

// Two sensors of one owner: the signature of one is none for the other.
TEST_F(SignedSubscription, WhoIsNotTheSensorThatIsMeantIsNamedAndNotBelieved) {
  wire::Key other = numbered_key(5);
  other.device = 2;
  SubscriptionOptions options = with({key_, other});
  options.device_id = 2;
  Subscription subscription(options, 5);
  for (int i = 0; i < 10; ++i) {
    const Bytes answer = answer_due(subscription);
    if (!answer.empty()) {
      EXPECT_TRUE(subscription.take(answer, now_));
    }
    now_ += 200ms;
  }
  EXPECT_EQ(subscription.state(), State::kAsking);
  EXPECT_EQ(subscription.other_sensor(), kSensor);
  EXPECT_EQ(subscription.stream_key().number, 0U);
  EXPECT_EQ(subscribers_.count(), 0U);
  options.device_id = kSensor;
  Subscription right(options, 5);
  talk(right);
  EXPECT_EQ(right.state(), State::kActive);
  EXPECT_FALSE(right.other_sensor());
}

}  // namespace
}  // namespace stof::client
