#include "host/client/control/pair_client.h"

#include <deque>
#include <functional>
#include <string>
#include <thread>

#include <gtest/gtest.h>

#include "firmware/control/request_handler.h"
#include "firmware/serial/line/serial_request_handler.h"
#include "firmware/wire/bytes.h"
#include "firmware/wire/crc32c.h"
#include "tests/firmware/control/requests.h"
#include "tests/firmware/keys/pairing_client.h"
#include "tests/firmware/keys/some_keys.h"

namespace stof::client {
namespace {

using namespace std::chrono_literals;
using test::Bytes;
using wire::PairMethod;
using wire::Role;

constexpr keys::LabelCode kCode{std::byte{9}};

// A sensor in memory, and whoever sits between it and the client.
struct SensorInMemory {
  SensorInMemory() {
    handler.set_pairing(&pairing);
    line.set_pairing(&pairing);
  }

  keys::Keyring ring{nullptr, nullptr};
  keys::PairingServer pairing{{.device_id = 1, .session_id = 7}, ring, kCode};
  firmware::LeaseTable subscribers;
  firmware::RequestHandler handler{
      {.device_id = 1, .session_id = 7}, firmware::CookieSecret{}, subscribers, nullptr};
  firmware::SerialRequestHandler line{{.device_id = 1, .session_id = 7}, nullptr, &handler};
  hal::Time now{1000s};
  std::function<void(Bytes&)> to_sensor = [](Bytes&) {};
  std::function<void(Bytes&)> to_client = [](Bytes&) {};
  // What a stranger of the link says upon a request, before the sensor.
  std::function<std::vector<Bytes>(const Bytes&)> stranger = [](const Bytes&) {
    return std::vector<Bytes>{};
  };
};

void reseal(Bytes& packet) {
  const std::size_t end = packet.size() - wire::kCrcBytes;
  wire::put_u32(std::span(packet).last<4>(), wire::crc32c(std::span(packet).first(end)));
}

enum class Way : std::uint8_t { kNetwork, kSerialLine, kBroadcast };

class Wire final : public ControlTransport {
 public:
  Wire(SensorInMemory& sensor, Way way) : sensor_(sensor), way_(way) {}
  Status send(std::span<const std::byte> packet) override {
    Bytes request(packet.begin(), packet.end());
    sensor_.to_sensor(request);
    std::ranges::move(sensor_.stranger(request), std::back_inserter(waiting_));
    const auto answer = way_ == Way::kSerialLine
                            ? sensor_.line.take(request, sensor_.now)
                            : sensor_.handler.take(request, test::peer(1), sensor_.now);
    if (!answer.empty()) {
      waiting_.emplace_back(answer.begin(), answer.end());
      sensor_.to_client(waiting_.back());
      if (waiting_.back().empty()) {
        waiting_.pop_back();
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
  Reach reach() const override {
    switch (way_) {
      case Way::kBroadcast:
        return Reach::kLink;
      case Way::kSerialLine:
        return Reach::kLine;
      default:
        return Reach::kAddress;
    }
  }

 private:
  SensorInMemory& sensor_;
  Way way_;
  std::deque<Bytes> waiting_;
};

PairClient client_of(SensorInMemory& sensor, const PairWish& wish, Way way = Way::kNetwork) {
  return {std::make_unique<Wire>(sensor, way), wish, {.timeout = 3ms}};
}

TEST(PairClient, ComparesDigitsAndWaitsForTheSensor) {
  SensorInMemory sensor;
  PairClient early = client_of(sensor, {.name = "ann"});
  const auto closed = early.start();
  ASSERT_FALSE(closed);
  EXPECT_EQ(closed.error().status, Status::kUnsupported);
  sensor.pairing.open(sensor.now);
  PairClient client = client_of(sensor, {.role = Role::kTune, .name = "ann b"});
  ASSERT_TRUE(client.start());
  EXPECT_EQ(client.digits(), sensor.pairing.digits());
  const auto key = client.finish(1s, [&sensor] {
    sensor.pairing.tick(sensor.now);
    sensor.pairing.hold(sensor.now);
    return true;
  });
  ASSERT_TRUE(key) << key.error().message;
  ASSERT_EQ(sensor.ring.keys().count(), 1U);
  EXPECT_EQ(*key, sensor.ring.keys().all()[0]);
  EXPECT_EQ(key->name_text(), "ann-b");
  EXPECT_EQ(key->role, Role::kTune);
}

// Whatever its user does then: nobody's hold makes a key that nobody has.
TEST(PairClient, WhoGivesUpEndsItAtTheSensor) {
  SensorInMemory sensor;
  const auto hold = [&sensor] {
    sensor.pairing.tick(sensor.now);
    sensor.pairing.hold(sensor.now);
  };
  for (const int stage : {0, 1, 2}) {
    sensor.pairing.open(sensor.now);
    auto client =
        std::make_unique<PairClient>(std::make_unique<Wire>(sensor, Way::kNetwork),
                                     PairWish{.name = "ann"}, ControlOptions{.timeout = 3ms});
    ASSERT_TRUE(client->start());
    ASSERT_TRUE(sensor.pairing.digits().has_value());
    if (stage == 1) {
      EXPECT_EQ(client->finish(1ms).error().status, Status::kTimeout);
    } else if (stage == 2) {
      EXPECT_EQ(client->finish(10s, [] { return false; }).error().status, Status::kTimeout);
    }
    if (stage == 0) {
      client.reset();
    }
    EXPECT_FALSE(sensor.pairing.digits().has_value());
    hold();
    EXPECT_EQ(sensor.ring.keys().count(), 0U);
  }
  auto holder =
      std::make_unique<PairClient>(std::make_unique<Wire>(sensor, Way::kSerialLine),
                                   PairWish{.name = "bob"}, ControlOptions{.timeout = 3ms});
  ASSERT_TRUE(holder->open_window());
  ASSERT_TRUE(sensor.pairing.is_open());
  holder.reset();
  EXPECT_FALSE(sensor.pairing.is_open());
}

TEST(PairClient, WhoeverHoldsTheCableLetsAnotherPair) {
  SensorInMemory sensor;
  int lost = 0;
  sensor.to_client = [&lost](Bytes& answer) {
    if (++lost % 2 == 0) {
      answer.clear();
    }
  };
  PairClient holder = client_of(sensor, {.name = "bob"}, Way::kSerialLine);
  const auto opened = holder.open_window();
  ASSERT_TRUE(opened) << opened.error().message;
  EXPECT_FALSE(opened->offer.has_value());
  PairClient client = client_of(sensor, {.role = Role::kTune, .name = "ann"});
  ASSERT_TRUE(client.start());
  const auto come = holder.open_window();
  ASSERT_TRUE(come);
  ASSERT_TRUE(come->offer.has_value());
  EXPECT_EQ(come->offer->digits, client.digits());
  EXPECT_EQ(come->offer->role, Role::kTune);
  EXPECT_EQ(come->key_id, 0U);
  const auto accepted = holder.accept(come->offer->digits);
  ASSERT_TRUE(accepted);
  EXPECT_EQ(accepted->key_id, 0U);
  const auto key = client.finish(1s);
  ASSERT_TRUE(key) << key.error().message;
  const auto over = holder.open_window();
  ASSERT_TRUE(over);
  EXPECT_EQ(over->key_id, key->id);
  ASSERT_EQ(sensor.ring.keys().count(), 1U);
}

TEST(PairClient, WhoeverHoldsTheCableIsToldHowItEnds) {
  SensorInMemory sensor;
  PairClient stranger = client_of(sensor, {.name = "eve"});
  EXPECT_EQ(stranger.open_window().error().status, Status::kUnsupported);
  PairClient holder = client_of(sensor, {.name = "bob"}, Way::kSerialLine);
  ASSERT_TRUE(holder.open_window());
  PairClient client = client_of(sensor, {.name = "ann"});
  ASSERT_TRUE(client.start());
  EXPECT_EQ(holder.accept((client.digits() + 1) % 1'000'000).error().status, Status::kCorrupt);
  EXPECT_EQ(client.finish(1s).error().status, Status::kCorrupt);
  EXPECT_EQ(holder.open_window().error().status, Status::kTimeout);
  sensor.line.set_remote(true);
  PairClient remote = client_of(sensor, {.name = "bob"}, Way::kSerialLine);
  const auto silent = remote.open_window();
  ASSERT_FALSE(silent);
  EXPECT_NE(silent.error().message.find("serial.remote"), std::string::npos);
  EXPECT_EQ(sensor.ring.keys().count(), 0U);

  SensorInMemory older;  // which knows no such step
  older.to_sensor = [](Bytes& packet) {
    packet[wire::kHeaderBytes + 4] = std::byte{99};
    reseal(packet);
  };
  PairClient newer = client_of(older, {.name = "bob"}, Way::kSerialLine);
  EXPECT_NE(newer.open_window().error().message.find("is older than this program"),
            std::string::npos);
}

TEST(PairClient, TheCodeHasToBeTheSensors) {
  SensorInMemory sensor;
  PairWish wish{.method = PairMethod::kCode, .name = "ann", .known = {kCode.begin(), kCode.end()}};
  PairClient client = client_of(sensor, wish);
  ASSERT_TRUE(client.start());
  const auto key = client.finish(1s);
  ASSERT_TRUE(key);
  EXPECT_EQ(*key, sensor.ring.keys().all()[0]);
  wish.known[3] ^= std::byte{1};
  PairClient wrong = client_of(sensor, wish);
  const auto refused = wrong.start();
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().status, Status::kCorrupt);
}

TEST(PairClient, RepeatsWhatGetsLost) {
  SensorInMemory sensor;
  int answers = 0;
  sensor.to_client = [&answers](Bytes& answer) {
    if (++answers % 2 == 0) {
      answer.clear();
    }
  };
  PairClient client = client_of(
      sensor, {.method = PairMethod::kCode, .name = "ann", .known = {kCode.begin(), kCode.end()}});
  ASSERT_TRUE(client.start());
  const auto key = client.finish(1s);
  ASSERT_TRUE(key) << key.error().message;
  ASSERT_EQ(sensor.ring.keys().count(), 1U);
  EXPECT_EQ(*key, sensor.ring.keys().all()[0]);
}

// All of the link hear the number of the request.
Bytes forged(const Bytes& request, wire::PairResult result, std::uint64_t cookie) {
  const auto packet = wire::parse_packet(request);
  const auto asked = wire::decode_pair_request(packet->payload);
  Bytes payload(wire::kPairAnswerBytes);
  wire::encode_pair_answer({.request_id = asked->request_id, .result = result, .cookie = cookie},
                           std::span(payload).first<wire::kPairAnswerBytes>());
  return test::sealed(wire::PacketType::kPairAnswer, payload, 1, 7);
}

bool confirms(const Bytes& request) {
  return wire::decode_pair_request(wire::parse_packet(request)->payload)->step ==
         wire::PairStep::kConfirm;
}

TEST(PairClient, NobodyElseEndsTheLastStep) {
  for (const Way way : {Way::kBroadcast, Way::kNetwork}) {
    for (const wire::PairResult lie :
         {wire::PairResult::kWrong, wire::PairResult::kCookie, wire::PairResult::kWaiting,
          wire::PairResult::kOk, wire::PairResult::kFull}) {
      SensorInMemory sensor;
      sensor.stranger = [lie, n = std::uint64_t{66}](const Bytes& request) mutable {
        return confirms(request) ? std::vector<Bytes>{forged(request, lie, n++)}
                                 : std::vector<Bytes>{};
      };
      PairClient client = client_of(
          sensor,
          {.method = PairMethod::kCode, .name = "ann", .known = {kCode.begin(), kCode.end()}}, way);
      ASSERT_TRUE(client.start());
      const auto key = client.finish(1s);
      ASSERT_TRUE(key) << key.error().message;
      EXPECT_EQ(*key, sensor.ring.keys().all()[0]);
    }
  }
}

TEST(PairClient, ByAddressNobodyElseRefusesAStep) {
  for (const wire::PairResult lie :
       {wire::PairResult::kWrong, wire::PairResult::kClosed, wire::PairResult::kFull}) {
    SensorInMemory sensor;
    sensor.stranger = [lie](const Bytes& request) {
      return std::vector<Bytes>{forged(request, lie, 66)};
    };
    PairClient client = client_of(
        sensor,
        {.method = PairMethod::kCode, .name = "ann", .known = {kCode.begin(), kCode.end()}});
    const auto begun = client.start();
    ASSERT_TRUE(begun) << begun.error().message;
    const auto key = client.finish(1s);
    ASSERT_TRUE(key) << key.error().message;
    EXPECT_EQ(*key, sensor.ring.keys().all()[0]);
  }
}

TEST(PairClient, WhoeverAsksForACookieForEverIsNoSensorThatDoesNotRun) {
  SensorInMemory sensor;
  sensor.stranger = [n = std::uint64_t{66}](const Bytes& request) mutable {
    return std::vector<Bytes>{forged(request, wire::PairResult::kCookie, n++)};
  };
  sensor.to_client = [](Bytes& answer) { answer.clear(); };
  PairClient client = client_of(
      sensor, {.method = PairMethod::kCode, .name = "ann", .known = {kCode.begin(), kCode.end()}});
  const auto begun = client.start();
  ASSERT_FALSE(begun);
  EXPECT_NE(begun.error().message.find("asks for another cookie"), std::string::npos)
      << begun.error().message;
}

TEST(PairClient, WhereTheLastAnswerDoesNotComeAKeyMayHaveBeenMade) {
  const PairWish wish{
      .method = PairMethod::kCode, .name = "ann", .known = {kCode.begin(), kCode.end()}};
  for (const Way way : {Way::kNetwork, Way::kBroadcast, Way::kSerialLine}) {
    for (const bool refused : {false, true}) {
      SensorInMemory sensor;
      bool last = false;
      sensor.stranger = [&last, refused](const Bytes& request) {
        last = confirms(request);
        return last && refused ? std::vector<Bytes>{forged(request, wire::PairResult::kWrong, 66)}
                               : std::vector<Bytes>{};
      };
      sensor.to_client = [&last](Bytes& answer) {
        if (last) {
          answer.clear();
        }
      };
      PairClient client = client_of(sensor, wish, way);
      ASSERT_TRUE(client.start());
      const auto key = client.finish(1s);
      ASSERT_FALSE(key);
      ASSERT_EQ(sensor.ring.keys().count(), 1U);
      EXPECT_NE(key.error().message.find("stof unpair --list tells"), std::string::npos)
          << key.error().message;
      EXPECT_EQ(key.error().message.find("nothing was paired") != std::string::npos,
                refused && way != Way::kBroadcast)
          << key.error().message;
      EXPECT_EQ(key.error().message.find("address") != std::string::npos,
                !refused && way != Way::kSerialLine)
          << key.error().message;
    }
  }
}

// Whatever bit is changed on the way, in either direction: no key, or the sensor's.
TEST(PairClient, WhoeverChangesAnythingIsSeen) {
  constexpr std::size_t kFirst = wire::kHeaderBytes + 4;  // behind the request id
  for (const bool upwards : {true, false}) {
    const std::size_t bytes = upwards ? wire::kPairRequestBytes : wire::kPairAnswerBytes;
    for (std::size_t at = kFirst; at < wire::kHeaderBytes + bytes; ++at) {
      SensorInMemory sensor;
      int seen = 0;
      const auto flip = [&seen, at](Bytes& packet) {
        if (++seen == 2) {  // the first that counts
          packet[at] ^= std::byte{1};
          reseal(packet);
        }
      };
      (upwards ? sensor.to_sensor : sensor.to_client) = flip;
      PairClient client = client_of(
          sensor,
          {.method = PairMethod::kCode, .name = "ann", .known = {kCode.begin(), kCode.end()}});
      const auto started = client.start();
      const auto key = started ? client.finish(1ms) : std::unexpected(started.error());
      if (key) {
        ASSERT_EQ(sensor.ring.keys().count(), 1U);
        ASSERT_EQ(key->secret, sensor.ring.keys().all()[0].secret) << upwards << " " << at;
      } else {
        ASSERT_EQ(sensor.ring.keys().count(), 0U) << upwards << " " << at;
      }
    }
  }
}

TEST(PairClient, AKeyGetsANewSecret) {
  SensorInMemory sensor;
  const wire::Key old = test::numbered_key(5, Role::kView);
  ASSERT_EQ(sensor.ring.add(old), Status::kOk);
  PairClient client = client_of(sensor, {.method = PairMethod::kKey,
                                         .role = old.role,
                                         .name = std::string(old.name_text()),
                                         .known = {old.secret.begin(), old.secret.end()},
                                         .key_id = old.id});
  ASSERT_TRUE(client.start());
  const auto key = client.finish(1s);
  ASSERT_TRUE(key);
  EXPECT_NE(key->secret, old.secret);
  const wire::Key& kept = sensor.ring.keys().all()[0];
  EXPECT_EQ(kept.secret, key->secret);
  EXPECT_EQ(kept.id, key->id);
  EXPECT_EQ(kept.role, key->role);
  EXPECT_EQ(kept.name, key->name);
}

// A stranger who begins again and again, and knows nothing.
TEST(PairClient, NobodyWhoKnowsNothingKeepsItFromARenewal) {
  SensorInMemory sensor;
  const wire::Key old = test::numbered_key(5, Role::kView);
  ASSERT_EQ(sensor.ring.add(old), Status::kOk);
  sensor.to_sensor = [&sensor](Bytes&) {
    for (const PairMethod method : {PairMethod::kCode, PairMethod::kKey}) {
      test::PairingClient stranger({.device_id = 1, .session_id = 7}, method, Role::kAdmin, {},
                                   method == PairMethod::kKey ? 5 : 0);
      static_cast<void>(
          sensor.pairing.serve(stranger.begin(), keys::PairingWay::kNetwork, sensor.now));
    }
  };
  PairClient client = client_of(sensor, {.method = PairMethod::kKey,
                                         .role = old.role,
                                         .name = std::string(old.name_text()),
                                         .known = {old.secret.begin(), old.secret.end()},
                                         .key_id = old.id});
  const auto started = client.start();
  ASSERT_TRUE(started) << started.error().message;
  const auto key = client.finish(1s);
  ASSERT_TRUE(key) << key.error().message;
  EXPECT_EQ(sensor.ring.keys().all()[0].secret, key->secret);
  PairClient by_code = client_of(
      sensor, {.method = PairMethod::kCode, .name = "ann", .known = {kCode.begin(), kCode.end()}});
  ASSERT_TRUE(by_code.start());
  EXPECT_TRUE(by_code.finish(1s));
}

}  // namespace
}  // namespace stof::client
