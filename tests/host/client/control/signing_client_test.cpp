#include <deque>
#include <functional>
#include <optional>
#include <string>
#include <thread>

#include <gtest/gtest.h>

#include "firmware/control/request_handler.h"
#include "firmware/wire/bytes.h"
#include "firmware/wire/crc32c.h"
#include "host/client/control/control_client.h"
#include "tests/firmware/keys/signed_requests.h"
#include "tests/firmware/keys/some_keys.h"

namespace stof::client {
namespace {

using namespace std::chrono_literals;
using firmware::Access;
using test::Bytes;
using test::numbered_key;
using wire::SettingsOperation;
using wire::SettingsResult;

constexpr std::uint32_t kDevice = 1;

// Notes with what access it is asked.
class Noting final : public firmware::SettingsService {
 public:
  wire::SettingsAnswer serve(const wire::SettingsRequest& /*request*/,
                             std::span<const std::byte> /*text*/, const firmware::Requester& by,
                             std::span<std::byte> answer_text,
                             std::size_t& answer_bytes) noexcept override {
    ++served;
    access = by.access;
    answer_bytes = 2;
    answer_text[0] = std::byte{'{'};
    answer_text[1] = std::byte{'}'};
    return {.result = SettingsResult::kOk, .total = 2, .revision = 9};
  }
  int served = 0;
  Access access = Access::kRead;
};

// A sensor in memory, and whoever sits between it and the client.
struct SigningSensor {
  explicit SigningSensor(std::uint32_t session = 7) { start(session); }

  void start(std::uint32_t session) {
    authenticator.emplace(ring);
    handler.emplace(wire::Origin{.device_id = kDevice, .session_id = session},
                    firmware::CookieSecret{static_cast<std::byte>(session)}, subscribers, &settings,
                    &*authenticator);
  }
  Bytes take(std::span<const std::byte> packet) {
    const auto answer = handler->take(packet, test::peer(1), hal::Time(1000s));
    return {answer.begin(), answer.end()};
  }

  keys::Keyring ring{nullptr, nullptr};
  firmware::LeaseTable subscribers;
  Noting settings;
  std::optional<keys::Authenticator> authenticator;
  std::optional<firmware::RequestHandler> handler;
  Reach reach = Reach::kAddress;
  std::function<std::vector<Bytes>(Bytes)> between = [](Bytes answer) {
    return std::vector<Bytes>{std::move(answer)};
  };
};

class Cable final : public ControlTransport {
 public:
  explicit Cable(SigningSensor& sensor) : sensor_(sensor) {}
  Status send(std::span<const std::byte> packet) override {
    if (Bytes answer = sensor_.take(packet); !answer.empty()) {
      for (Bytes& arriving : sensor_.between(std::move(answer))) {
        waiting_.push_back(std::move(arriving));
      }
    }
    return Status::kOk;
  }
  Result<Bytes> receive(Duration /*timeout*/) override {
    if (waiting_.empty()) {
      std::this_thread::sleep_for(1ms);
      return fail(Status::kTimeout);
    }
    Bytes packet = std::move(waiting_.front());
    waiting_.pop_front();
    return packet;
  }
  std::string place() const override { return "memory"; }
  Reach reach() const override { return sensor_.reach; }

 private:
  SigningSensor& sensor_;
  std::deque<Bytes> waiting_;
};

ControlClient client_of(SigningSensor& sensor, std::initializer_list<wire::Key> keys) {
  ControlOptions options{.timeout = 3ms};
  for (const wire::Key& key : keys) {
    EXPECT_EQ(options.keys.add(key), Status::kOk);
  }
  return ControlClient(std::make_unique<Cable>(sensor), options);
}

std::expected<ControlAnswer, ControlError> set(ControlClient& client) {
  return client.request(SettingsOperation::kSet, {}, "{}");
}

std::uint32_t request_id_of(const Bytes& answer) {
  const auto packet = wire::parse_packet(answer);
  const auto view = wire::open_signed(*packet, answer);
  return wire::decode_settings_answer(view ? view->payload : packet->payload)->request_id;
}

TEST(SigningClient, SignsWithTheKeyThatItHasOfTheSensor) {
  SigningSensor sensor;
  ASSERT_EQ(sensor.ring.add(numbered_key(4, wire::Role::kTune)), Status::kOk);
  wire::Key other = numbered_key(5);
  other.device = kDevice + 1;
  ControlClient client = client_of(sensor, {numbered_key(4, wire::Role::kTune), other});
  for (int i = 0; i < 5; ++i) {
    const auto answer = set(client);
    ASSERT_TRUE(answer) << answer.error().message;
    EXPECT_EQ(answer->result, SettingsResult::kOk);
    EXPECT_EQ(answer->revision, 9U);
    EXPECT_EQ(sensor.settings.access, Access::kTune);
  }
  EXPECT_EQ(sensor.settings.served, 5);
  EXPECT_EQ(client.request(SettingsOperation::kGet, {}, "").value().text, "{}");
}

TEST(SigningClient, WithoutAnyKeyItAsksWithoutASignature) {
  SigningSensor sensor;
  ControlClient client = client_of(sensor, {});
  EXPECT_EQ(set(client).value().result, SettingsResult::kOk);
  EXPECT_EQ(sensor.settings.access, Access::kHarmless);
}

TEST(SigningClient, WhoeverSaysThatHeIsAnotherSensorIsNotBelieved) {
  SigningSensor sensor;
  ASSERT_EQ(sensor.ring.add(numbered_key(4)), Status::kOk);
  sensor.between = [](Bytes answer) {  // another number, and no signature: all is well
    const auto packet = wire::parse_packet(answer);
    Bytes lie(packet->payload.begin(), packet->payload.end());
    return std::vector<Bytes>{test::sealed(wire::PacketType::kSettingsAnswer, lie, kDevice + 8)};
  };
  ControlClient client = client_of(sensor, {numbered_key(4)});
  const auto answer = set(client);
  ASSERT_FALSE(answer);
  EXPECT_EQ(answer.error().status, Status::kUnsupported);
  EXPECT_NE(answer.error().message.find("number 9, of which you have no key"), std::string::npos);
  EXPECT_EQ(sensor.settings.served, 0);
  EXPECT_EQ(client.request(SettingsOperation::kGet, {}, "").value().text, "{}");  // is only read

  SigningSensor unpaired;
  wire::Key other = numbered_key(4);
  other.device = kDevice + 8;
  EXPECT_FALSE(set(*std::make_unique<ControlClient>(client_of(unpaired, {other}))));
  ControlOptions named{.timeout = 3ms, .device_id = kDevice};  // who says which one he means
  EXPECT_EQ(named.keys.add(other), Status::kOk);
  ControlClient knows(std::make_unique<Cable>(unpaired), named);
  EXPECT_TRUE(set(knows));
}

TEST(SigningClient, AnAnswerWithoutASignatureToItsFirstRequestIsNotBelieved) {
  SigningSensor sensor;
  ASSERT_EQ(sensor.ring.add(numbered_key(4)), Status::kOk);
  sensor.between = [first = true](Bytes answer) mutable {
    const auto packet = wire::parse_packet(answer);
    if (!std::exchange(first, false)) {
      return std::vector<Bytes>{std::move(answer)};
    }
    auto lie = *wire::decode_settings_answer(packet->payload);
    lie.result = SettingsResult::kOk;
    Bytes payload(wire::kSettingsAnswerBytes);
    wire::encode_settings_answer(lie, std::span(payload).first<wire::kSettingsAnswerBytes>());
    return std::vector<Bytes>{test::sealed(wire::PacketType::kSettingsAnswer, payload, kDevice)};
  };
  ControlClient client = client_of(sensor, {numbered_key(4)});
  ASSERT_TRUE(set(client));
  EXPECT_EQ(sensor.settings.served, 1);
  EXPECT_EQ(sensor.settings.access, Access::kAdmin);
}

TEST(SigningClient, WhereSignedAloneIsAskedForNoDocumentIsBelievedWithout) {
  const auto alone = [](SigningSensor& sensor, const wire::Key& key) {
    ControlOptions options{.timeout = 3ms, .signed_alone = true};
    EXPECT_EQ(options.keys.add(key), Status::kOk);
    return ControlClient(std::make_unique<Cable>(sensor), options)
        .request(SettingsOperation::kGet, {}, "");
  };
  SigningSensor sensor;
  ASSERT_EQ(sensor.ring.add(numbered_key(4)), Status::kOk);
  EXPECT_EQ(alone(sensor, numbered_key(4)).value().text, "{}");
  EXPECT_EQ(sensor.settings.access, Access::kAdmin);

  const auto refused = alone(sensor, numbered_key(5));  // the sensor has it not
  ASSERT_FALSE(refused);
  EXPECT_NE(refused.error().message.find("has none of your keys"), std::string::npos);
  wire::Key other = numbered_key(4);
  other.device = kDevice + 8;
  const auto unknown = alone(sensor, other);
  ASSERT_FALSE(unknown);
  EXPECT_NE(unknown.error().message.find("nothing proves what it tells"), std::string::npos);

  sensor.between = [](Bytes answer) {  // somebody is faster
    Bytes lie(wire::kSettingsAnswerBytes + 2);
    wire::encode_settings_answer(
        {.request_id = request_id_of(answer), .result = SettingsResult::kOk, .total = 2},
        std::span(lie).first<wire::kSettingsAnswerBytes>());
    return std::vector<Bytes>{test::sealed(wire::PacketType::kSettingsAnswer, lie, kDevice, 7),
                              std::move(answer)};
  };
  EXPECT_EQ(alone(sensor, numbered_key(4)).value().text, "{}");
}

TEST(SigningClient, ThatItsLastCounterIsUsedUpIsSaid) {
  SigningSensor sensor;
  ASSERT_EQ(sensor.ring.add(numbered_key(4)), Status::kOk);
  ControlClient client = client_of(sensor, {numbered_key(4)});
  ASSERT_TRUE(set(client));
  const std::uint64_t cookie =
      firmware::Cookies(firmware::CookieSecret{std::byte{7}}).make(test::peer(1), hal::Time(1000s));
  const wire::Key key = numbered_key(4);
  ASSERT_TRUE(test::signed_reply(
      key, sensor.take(test::signed_settings(key, {.device_id = kDevice, .session_id = 7},
                                             ~std::uint64_t{0}, {.cookie = cookie}))));
  const auto answer = set(client);
  ASSERT_FALSE(answer);
  EXPECT_NE(answer.error().message.find("until it starts again"), std::string::npos);
}

TEST(SigningClient, GoesOnAfterARestartOfTheSensor) {
  SigningSensor sensor;
  ASSERT_EQ(sensor.ring.add(numbered_key(4)), Status::kOk);
  ControlClient client = client_of(sensor, {numbered_key(4)});
  ASSERT_EQ(set(client).value().result, SettingsResult::kOk);
  sensor.start(8);
  ASSERT_EQ(set(client).value().result, SettingsResult::kOk);
  EXPECT_EQ(sensor.settings.access, Access::kAdmin);
}

TEST(SigningClient, SeveralProgramsShareAKey) {
  SigningSensor sensor;
  ASSERT_EQ(sensor.ring.add(numbered_key(4)), Status::kOk);
  ControlClient one = client_of(sensor, {numbered_key(4)});
  ControlClient two = client_of(sensor, {numbered_key(4)});
  for (int i = 0; i < 20; ++i) {
    ASSERT_EQ(set(i % 3 == 0 ? one : two).value().result, SettingsResult::kOk) << i;
  }
  // And one whose clock is years ahead.
  const std::uint64_t cookie =
      firmware::Cookies(firmware::CookieSecret{std::byte{7}}).make(test::peer(1), hal::Time(1000s));
  const wire::Key key = numbered_key(4);
  ASSERT_TRUE(test::signed_reply(
      key, sensor.take(test::signed_settings(key, {.device_id = kDevice, .session_id = 7},
                                             std::uint64_t{1} << 62U, {.cookie = cookie}))));
  ASSERT_EQ(set(one).value().result, SettingsResult::kOk);
  ASSERT_EQ(set(two).value().result, SettingsResult::kOk);
}

TEST(SigningClient, TriesItsOlderKeysAndSaysWhereNoneIsKnown) {
  SigningSensor sensor;
  ASSERT_EQ(sensor.ring.add(numbered_key(4)), Status::kOk);
  ControlClient two = client_of(sensor, {numbered_key(4), numbered_key(5)});
  EXPECT_EQ(set(two).value().result, SettingsResult::kOk);
  EXPECT_EQ(sensor.settings.access, Access::kAdmin);
  ControlClient wrong = client_of(sensor, {numbered_key(5), numbered_key(6)});
  const int served = sensor.settings.served;
  EXPECT_EQ(set(wrong).value().result, SettingsResult::kUnknownKey);
  EXPECT_EQ(set(wrong).value().result, SettingsResult::kUnknownKey);
  EXPECT_EQ(sensor.settings.served, served);
  EXPECT_EQ(wrong.request(SettingsOperation::kGet, {}, "").value().text, "{}");
}

TEST(SigningClient, BelievesNothingThatTheSensorDidNotSign) {
  SigningSensor sensor;
  ASSERT_EQ(sensor.ring.add(numbered_key(4)), Status::kOk);
  ControlClient client = client_of(sensor, {numbered_key(4)});
  ASSERT_TRUE(set(client));
  sensor.between = [](Bytes answer) {  // each bit of it in turn, and an answer without a signature
    std::vector<Bytes> arriving;
    for (std::size_t i = 0; i < answer.size() - wire::kCrcBytes; ++i) {
      Bytes bad = answer;
      bad[i] ^= static_cast<std::byte>(1U << i % 8);
      const std::size_t end = bad.size() - wire::kCrcBytes;
      wire::put_u32(std::span(bad).last<4>(), wire::crc32c(std::span(bad).first(end)));
      arriving.push_back(bad);
    }
    const auto packet = wire::parse_packet(answer);
    const auto view = wire::open_signed(*packet, answer);
    const Bytes plain = test::sealed(wire::PacketType::kSettingsAnswer, view->payload, kDevice);
    arriving.push_back(plain);
    return arriving;
  };
  const auto answer = set(client);
  ASSERT_FALSE(answer);
  EXPECT_EQ(answer.error().status, Status::kTimeout);
}

// What anybody says who hears the number of a request.
Bytes forged(std::uint32_t request_id, SettingsResult result, std::uint64_t cookie,
             std::uint32_t session = 7) {
  Bytes payload(wire::kSettingsAnswerBytes);
  wire::encode_settings_answer({.request_id = request_id, .result = result, .cookie = cookie},
                               std::span(payload).first<wire::kSettingsAnswerBytes>());
  return test::sealed(wire::PacketType::kSettingsAnswer, payload, kDevice, session);
}

class WhoAnswersFirst : public testing::TestWithParam<Reach> {};

TEST_P(WhoAnswersFirst, EndsNoRequest) {
  for (const SettingsResult lie : {SettingsResult::kUnknownKey, SettingsResult::kCookie}) {
    SigningSensor sensor;
    sensor.reach = GetParam();
    ASSERT_EQ(sensor.ring.add(numbered_key(4)), Status::kOk);
    ControlClient client = client_of(sensor, {numbered_key(4)});
    ASSERT_TRUE(set(client));
    sensor.between = [lie, cookie = std::uint64_t{66}](Bytes answer) mutable {
      return std::vector<Bytes>{forged(request_id_of(answer), lie, cookie++), std::move(answer)};
    };
    for (int i = 0; i < 5; ++i) {
      const auto answer = set(client);
      ASSERT_TRUE(answer) << answer.error().message;
      EXPECT_EQ(answer->result, SettingsResult::kOk) << i;
    }
    ControlClient later = client_of(sensor, {numbered_key(4)});
    const auto answer = set(later);
    ASSERT_TRUE(answer) << answer.error().message;
    EXPECT_EQ(answer->result, SettingsResult::kOk);
  }
}

TEST_P(WhoAnswersFirst, StarvesNoRequestByCookiesOfMadeUpSessions) {
  SigningSensor sensor;
  sensor.reach = GetParam();
  ASSERT_EQ(sensor.ring.add(numbered_key(4)), Status::kOk);
  sensor.between = [n = std::uint32_t{66}](Bytes answer) mutable {
    ++n;
    return std::vector<Bytes>{forged(request_id_of(answer), SettingsResult::kCookie, n, n),
                              std::move(answer)};
  };
  ControlClient client = client_of(sensor, {numbered_key(4)});
  for (int i = 0; i < 5; ++i) {
    const auto answer = set(client);
    ASSERT_TRUE(answer) << i << answer.error().message;
    EXPECT_EQ(answer->result, SettingsResult::kOk);
  }
}

INSTANTIATE_TEST_SUITE_P(SigningClient, WhoAnswersFirst,
                         testing::Values(Reach::kLink, Reach::kAddress));

TEST(SigningClient, ByBroadcastARefusalWithoutASignatureSaysThatItProvesNothing) {
  SigningSensor sensor;
  sensor.reach = Reach::kLink;
  ASSERT_EQ(sensor.ring.add(numbered_key(4)), Status::kOk);
  ControlClient client = client_of(sensor, {numbered_key(4)});
  ASSERT_TRUE(set(client));
  sensor.between = [](const Bytes& answer) {
    return std::vector<Bytes>{forged(request_id_of(answer), SettingsResult::kUnknownKey, 66)};
  };
  const auto refused = set(client);
  ASSERT_TRUE(refused) << refused.error().message;
  EXPECT_EQ(refused->result, SettingsResult::kUnknownKey);
  EXPECT_NE(refused->text.find("as anybody of the link can"), std::string::npos);
  EXPECT_EQ(sensor.settings.served, 2);
}

TEST(SigningClient, CookiesWithoutEndAreNotCalledSilence) {
  SigningSensor sensor;
  ASSERT_EQ(sensor.ring.add(numbered_key(4)), Status::kOk);
  ControlClient client = client_of(sensor, {numbered_key(4)});
  ASSERT_TRUE(set(client));
  sensor.between = [cookie = std::uint64_t{66}](const Bytes& answer) mutable {
    return std::vector<Bytes>{forged(request_id_of(answer), SettingsResult::kCookie, cookie++)};
  };
  const auto answer = set(client);
  ASSERT_FALSE(answer);
  EXPECT_NE(answer.error().message.find("another cookie"), std::string::npos);
}

TEST(SigningClient, AnAnswerOfBeforeIsNotTheAnswerOfNow) {
  SigningSensor sensor;
  ASSERT_EQ(sensor.ring.add(numbered_key(4)), Status::kOk);
  ControlClient client = client_of(sensor, {numbered_key(4)});
  Bytes kept;
  sensor.between = [&kept](Bytes answer) {
    kept = answer;
    return std::vector<Bytes>{std::move(answer)};
  };
  ASSERT_TRUE(set(client));
  sensor.between = [&kept](const Bytes& /*answer*/) { return std::vector<Bytes>{kept}; };
  EXPECT_FALSE(set(client));
}

// Keys of two sensors prove that it is one of them, and not that it is the one that was asked for.
TEST(SigningClient, ChangesNothingWhereNobodyKnowsWhichSensorIsMeant) {
  SigningSensor sensor;
  ASSERT_EQ(sensor.ring.add(numbered_key(4)), Status::kOk);
  ControlOptions options{.timeout = 3ms, .doubt = "name the one that is meant"};
  ASSERT_EQ(options.keys.add(numbered_key(4)), Status::kOk);
  ControlClient client(std::make_unique<Cable>(sensor), options);
  for (const SettingsOperation operation :
       {SettingsOperation::kSet, SettingsOperation::kStage, SettingsOperation::kCommit,
        SettingsOperation::kRevert, SettingsOperation::kPreset, SettingsOperation::kSave,
        SettingsOperation::kReset, SettingsOperation::kKeys, SettingsOperation::kUnpair}) {
    const auto answer = client.request(operation, {}, "00000004");
    ASSERT_FALSE(answer);
    EXPECT_EQ(answer.error().status, Status::kUnsupported);
    EXPECT_NE(answer.error().message.find("--device"), std::string::npos);
  }
  EXPECT_EQ(sensor.settings.served, 0);
  EXPECT_TRUE(client.request(SettingsOperation::kGet, {}, {}));
}

TEST(SigningClient, SaysWhichSensorAnswersInPlaceOfTheOneThatIsMeant) {
  SigningSensor sensor;
  ASSERT_EQ(sensor.ring.add(numbered_key(4)), Status::kOk);
  ControlOptions options{.timeout = 3ms, .device_id = 2};
  ASSERT_EQ(options.keys.add(numbered_key(4)), Status::kOk);
  ControlClient client(std::make_unique<Cable>(sensor), options);
  const auto answer = set(client);
  ASSERT_FALSE(answer);
  EXPECT_NE(answer.error().message.find("number 1, but you named 2"), std::string::npos)
      << answer.error().message;
  EXPECT_NE(answer.error().message.find("--device 1"), std::string::npos);
  EXPECT_EQ(sensor.settings.served, 0);
  EXPECT_FALSE(client.proven());
}

TEST(SigningClient, KnowsWhichSensorHasProvenItself) {
  SigningSensor sensor;
  ASSERT_EQ(sensor.ring.add(numbered_key(4)), Status::kOk);
  ControlClient stranger = client_of(sensor, {});
  EXPECT_TRUE(stranger.request(SettingsOperation::kGet, {}, {}));
  EXPECT_FALSE(stranger.proven());
  ControlClient owner = client_of(sensor, {numbered_key(4)});
  ASSERT_TRUE(set(owner));
  ASSERT_TRUE(owner.proven());
  EXPECT_EQ(owner.proven()->device, kDevice);
  EXPECT_EQ(owner.proven()->key_id, 4U);
}

}  // namespace
}  // namespace stof::client
