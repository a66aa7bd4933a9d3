#include "firmware/keys/pairing_server.h"

#include <array>
#include <optional>
#include <utility>

#include <gtest/gtest.h>

#include "tests/firmware/keys/pairing_client.h"
#include "tests/firmware/keys/pairing_server_fixture.h"
#include "tests/firmware/keys/some_keys.h"
#include "tests/support/heap_guard.h"

namespace stof::keys {
namespace {

using namespace std::chrono_literals;
using test::numbered_key;
using test::PairingClient;
using wire::PairAnswer;
using wire::PairMethod;
using wire::PairRequest;
using wire::PairResult;
using wire::Role;

TEST_F(PairingServerTest, ByDigitsTakesThePressAndTheAcceptance) {
  PairingClient early(kSensor, PairMethod::kDigits, Role::kAdmin);
  EXPECT_EQ(run(early).result, PairResult::kClosed);
  server_.open(now_);
  EXPECT_TRUE(server_.is_open());
  PairingClient client(kSensor, PairMethod::kDigits, Role::kTune);
  EXPECT_FALSE(server_.digits().has_value());
  const PairAnswer waiting = run(client);
  EXPECT_EQ(waiting.result, PairResult::kWaiting);
  EXPECT_EQ(server_.digits(), client.secrets().digits());
  EXPECT_EQ(ask(client.confirm()).result, PairResult::kWaiting);
  EXPECT_EQ(ring_.pairing(), Pairing::kUnpaired);
  hold();
  EXPECT_FALSE(server_.digits().has_value());
  const PairAnswer done = ask(client.confirm());
  EXPECT_EQ(done.result, PairResult::kOk);
  EXPECT_EQ(wire::bytes_in<wire::Tag>(done.value), client.secrets().done_tag());
  ASSERT_EQ(ring_.keys().count(), 1U);
  EXPECT_TRUE(has_key_of(client, done.key_id));
  EXPECT_EQ(ring_.keys().all()[0].role, Role::kTune);
  EXPECT_EQ(ring_.keys().all()[0].name_text(), "client");
  EXPECT_EQ(ask(client.confirm()).result, PairResult::kOk);  // the answer was lost
  EXPECT_EQ(ring_.keys().count(), 1U);
  EXPECT_TRUE(server_.is_done());
}

TEST_F(PairingServerTest, TheSensorMayAcceptBeforeTheClientsUser) {
  server_.open(now_);
  hold();  // before there are digits it is nothing
  PairingClient client(kSensor, PairMethod::kDigits, Role::kAdmin);
  const PairAnswer begun = ask(client.begin());
  hold();
  ASSERT_EQ(ask(client.reveal(begun)).result, PairResult::kOk);
  EXPECT_EQ(ask(client.confirm()).result, PairResult::kWaiting);

  server_.open(now_);
  PairingClient second(kSensor, PairMethod::kDigits, Role::kAdmin);
  const PairAnswer again = ask(second.begin());
  ASSERT_EQ(ask(second.reveal(again)).result, PairResult::kOk);
  hold();
  EXPECT_EQ(ring_.keys().count(), 0U);  // the client's user has said nothing
  EXPECT_EQ(ask(second.confirm()).result, PairResult::kOk);
  EXPECT_EQ(ring_.keys().count(), 1U);
}

TEST_F(PairingServerTest, TheWindowEndsAfterTwoMinutes) {
  server_.open(now_);
  PairingClient client(kSensor, PairMethod::kDigits, Role::kAdmin);
  ASSERT_EQ(run(client).result, PairResult::kWaiting);
  now_ += PairingServer::kWindow - 1ms;
  EXPECT_EQ(ask(client.confirm()).result, PairResult::kWaiting);
  now_ += 1ms;
  EXPECT_EQ(ask(client.confirm()).result, PairResult::kWrong);
  EXPECT_FALSE(server_.is_open());
  hold();
  EXPECT_EQ(ring_.keys().count(), 0U);
  EXPECT_EQ(ask(client.begin()).result, PairResult::kClosed);
}

TEST_F(PairingServerTest, ASecondClientEndsBothAndAPressBeginsAnew) {
  server_.open(now_);
  PairingClient first(kSensor, PairMethod::kDigits, Role::kAdmin);
  PairingClient second(kSensor, PairMethod::kDigits, Role::kAdmin);
  ASSERT_EQ(run(first).result, PairResult::kWaiting);
  EXPECT_EQ(ask(second.begin()).result, PairResult::kBusy);
  hold();
  EXPECT_EQ(ask(first.confirm()).result, PairResult::kWrong);
  EXPECT_FALSE(server_.is_open());
  EXPECT_EQ(ring_.keys().count(), 0U);
  // Who opens again accepts nobody.
  server_.press(now_);
  ASSERT_EQ(run(first).result, PairResult::kWaiting);
  server_.open(now_);
  EXPECT_EQ(ask(first.confirm()).result, PairResult::kWrong);
  EXPECT_EQ(ring_.keys().count(), 0U);
}

TEST_F(PairingServerTest, AStepThatIsNoneDoesNothing) {
  PairingClient client(kSensor, PairMethod::kCode, Role::kAdmin, kCode);
  const PairAnswer begun = ask(client.begin());
  ASSERT_EQ(ask(client.reveal(begun)).result, PairResult::kOk);
  for (const int number : {5, 18, 255}) {
    PairRequest request = client.confirm();
    request.step = static_cast<wire::PairStep>(number);
    EXPECT_EQ(ask(request).result, PairResult::kWrong) << number;
  }
  EXPECT_EQ(ring_.keys().count(), 0U);
  EXPECT_EQ(ask(client.confirm()).result, PairResult::kOk);
}

TEST_F(PairingServerTest, LostAnswersAreRepeated) {
  server_.open(now_);
  PairingClient client(kSensor, PairMethod::kDigits, Role::kAdmin);
  const PairRequest begin = client.begin();
  const PairAnswer begun = ask(begin);
  const PairAnswer again = ask(begin);
  EXPECT_EQ(again.attempt, begun.attempt);
  EXPECT_EQ(again.value, begun.value);
  const PairRequest reveal = client.reveal(begun);
  EXPECT_EQ(ask(reveal).value, ask(reveal).value);
  EXPECT_EQ(ask(client.confirm()).result, PairResult::kWaiting);
}

TEST_F(PairingServerTest, WhoChangesHisMindAfterTheCommitmentIsOut) {
  for (const int part : {0, 1}) {
    server_.open(now_);
    PairingClient client(kSensor, PairMethod::kDigits, Role::kAdmin);
    PairRequest reveal = client.reveal(ask(client.begin()));
    (part == 0 ? reveal.value[5] : reveal.nonce[5]) ^= 1;
    EXPECT_EQ(ask(reveal).result, PairResult::kWrong);
    EXPECT_FALSE(server_.is_open());
  }
}

TEST_F(PairingServerTest, OneWrongTagEndsTheAttempt) {
  for (const PairMethod method : {PairMethod::kDigits, PairMethod::kCode}) {
    server_.open(now_);
    PairingClient client(kSensor, method, Role::kAdmin, kCode);
    ASSERT_EQ(ask(client.reveal(ask(client.begin()))).result, PairResult::kOk);
    PairRequest confirm = client.confirm();
    confirm.value[0] ^= 1;
    EXPECT_EQ(ask(confirm).result, PairResult::kWrong);
    EXPECT_EQ(ask(client.confirm()).result, PairResult::kWrong);
  }
  EXPECT_EQ(ring_.keys().count(), 0U);
}

TEST_F(PairingServerTest, StepsOutOfOrderOrOfNoAttemptAreRefused) {
  PairingClient client(kSensor, PairMethod::kCode, Role::kAdmin, kCode);
  EXPECT_EQ(ask(client.reveal({})).result, PairResult::kWrong);
  EXPECT_EQ(ask(client.confirm()).result, PairResult::kWrong);
  const PairAnswer begun = ask(client.begin());
  PairRequest other = client.reveal(begun);
  other.attempt ^= 1;
  EXPECT_EQ(ask(other).result, PairResult::kWrong);
  other.attempt ^= 1;
  other.method = PairMethod::kKey;
  EXPECT_EQ(ask(other).result, PairResult::kWrong);
  PairRequest confirm = client.confirm();
  EXPECT_EQ(ask(confirm).result, PairResult::kWrong);  // before reveal: it has ended
  EXPECT_EQ(ask(client.reveal(begun)).result, PairResult::kWrong);
}

TEST_F(PairingServerTest, TheLabelsCodeNeedsNobodyAndNoOtherCodeDoes) {
  PairingClient client(kSensor, PairMethod::kCode, Role::kAdmin, kCode);
  const PairAnswer done = run(client);
  EXPECT_EQ(done.result, PairResult::kOk);
  EXPECT_TRUE(has_key_of(client, done.key_id));
  LabelCode other = kCode;
  other[15] ^= std::byte{1};
  PairingClient guesses(kSensor, PairMethod::kCode, Role::kAdmin, other);
  const PairAnswer revealed = ask(guesses.reveal(ask(guesses.begin())));
  EXPECT_NE(wire::bytes_in<wire::Tag>(revealed.value), guesses.secrets().sensor_tag());
  EXPECT_EQ(ask(guesses.confirm()).result, PairResult::kWrong);
  EXPECT_EQ(ring_.keys().count(), 1U);
  EXPECT_EQ(without_code_.serve(client.begin(), PairingWay::kNetwork, now_).result,
            PairResult::kClosed);
}

TEST_F(PairingServerTest, TheCableNeedsNobodyAndIsNoNetwork) {
  PairingClient client(kSensor, PairMethod::kCable, Role::kAdmin);
  EXPECT_EQ(run(client).result, PairResult::kClosed);
  const PairAnswer done = run(client, PairingWay::kCable);
  EXPECT_EQ(done.result, PairResult::kOk);
  EXPECT_TRUE(has_key_of(client, done.key_id));
}

TEST_F(PairingServerTest, LostKeysAreHealedByTheCable) {
  store_.bytes().assign(5, std::byte{'x'});
  std::array<char, 320> space;
  settings::PagedWriter line(space);
  ring_.load("keys", line);
  ASSERT_EQ(ring_.pairing(), Pairing::kLost);
  PairingClient client(kSensor, PairMethod::kCable, Role::kAdmin);
  EXPECT_EQ(run(client, PairingWay::kCable).result, PairResult::kOk);
  EXPECT_EQ(ring_.pairing(), Pairing::kPaired);
}

TEST_F(PairingServerTest, AKeyGetsANewSecretFromWhoHasTheOldOne) {
  const wire::Key old = numbered_key(9, Role::kTune);
  ASSERT_EQ(ring_.add(old), Status::kOk);
  // The role cannot grow with it.
  PairingClient client(kSensor, PairMethod::kKey, Role::kAdmin, old.secret, 9);
  EXPECT_EQ(run(client).result, PairResult::kOk);
  ASSERT_EQ(ring_.keys().count(), 1U);
  EXPECT_TRUE(has_key_of(client, 9));
  EXPECT_EQ(ring_.keys().all()[0].role, Role::kTune);
  EXPECT_EQ(ring_.keys().all()[0].name_text(), "test");
  ring_.settle(9);
  PairingClient late(kSensor, PairMethod::kKey, Role::kTune, old.secret, 9);
  ASSERT_EQ(ask(late.reveal(ask(late.begin()))).result, PairResult::kOk);
  EXPECT_EQ(ask(late.confirm()).result, PairResult::kWrong);
  PairingClient nobody(kSensor, PairMethod::kKey, Role::kTune, old.secret, 10);
  EXPECT_EQ(run(nobody).result, PairResult::kClosed);
}

TEST_F(PairingServerTest, WhoNeverGotTheRenewalsAnswerRenewsAgain) {
  const wire::Key old = numbered_key(9, Role::kTune);
  ASSERT_EQ(ring_.add(old), Status::kOk);
  PairingClient lost(kSensor, PairMethod::kKey, Role::kTune, old.secret, 9);
  ASSERT_EQ(run(lost).result, PairResult::kOk);
  PairingClient again(kSensor, PairMethod::kKey, Role::kTune, old.secret, 9);
  EXPECT_EQ(run(again).result, PairResult::kOk);
  EXPECT_TRUE(has_key_of(again, 9));
  EXPECT_FALSE(has_key_of(lost, 9));
  EXPECT_EQ(ring_.keys().find(9)->former, old.secret);
}

TEST_F(PairingServerTest, TellsWhichKeyCameAndFromWhom) {
  firmware::ChangeRing changes;
  server_.set_changes(&changes);
  PairingClient client(kSensor, PairMethod::kCode, Role::kTune, kCode);
  from_ = {.address = {1, 2, 3}, .port = 4};
  const PairAnswer begun = ask(client.begin());
  static_cast<void>(ask(client.reveal(begun)));
  EXPECT_EQ(changes.size(), 0U);
  for (int i = 0; i < 2; ++i) {  // repeated, it is told once
    ASSERT_EQ(ask(client.confirm()).result, PairResult::kOk);
  }
  const auto change = changes.pop();
  ASSERT_TRUE(change.has_value());
  EXPECT_EQ(change->kind, firmware::EventKind::kKeyMade);
  EXPECT_EQ(change->value, ring_.keys().all()[0].id);
  EXPECT_EQ(change->role, Role::kTune);
  EXPECT_EQ(change->address, from_.address);
  EXPECT_EQ(changes.size(), 0U);
}

TEST_F(PairingServerTest, RolesAndNamesThatAreNoneBeginNothing) {
  for (const int role : {0, 4, 255}) {
    PairingClient client(kSensor, PairMethod::kCable, static_cast<Role>(role));
    EXPECT_EQ(run(client, PairingWay::kCable).result, PairResult::kWrong) << role;
  }
  for (const std::string_view name :
       {std::string_view(), std::string_view("a b"), std::string_view("\xC3\xA4"),
        std::string_view("a\0b", 3), std::string_view("a\n")}) {
    PairingClient client(kSensor, PairMethod::kCable, Role::kAdmin);
    client.said().name = {};
    std::ranges::copy(name, client.said().name.begin());
    EXPECT_EQ(run(client, PairingWay::kCable).result, PairResult::kWrong) << name;
  }
  EXPECT_EQ(ring_.pairing(), Pairing::kUnpaired);
}

TEST_F(PairingServerTest, APointThatAnybodyKnowsTheResultOfIsRefused) {
  server_.open(now_);
  PairingClient client(kSensor, PairMethod::kDigits, Role::kAdmin);
  client.said().client_key = {};
  EXPECT_EQ(ask(client.reveal(ask(client.begin()))).result, PairResult::kWrong);
}

TEST_F(PairingServerTest, NobodysRoleIsNotPaired) {
  server_.open(now_);
  PairingClient client(kSensor, PairMethod::kDigits, Role::kNone);
  EXPECT_EQ(run(client).result, PairResult::kWrong);
}

TEST_F(PairingServerTest, SaysWhereNoMoreKeysAreKept) {
  for (std::uint32_t id = 1; id <= kMostKeys; ++id) {
    ASSERT_EQ(ring_.add(numbered_key(id)), Status::kOk);
  }
  PairingClient client(kSensor, PairMethod::kCode, Role::kAdmin, kCode);
  EXPECT_EQ(run(client).result, PairResult::kFull);
  ASSERT_EQ(ring_.remove(1), Status::kOk);
  store_.break_down(true);
  PairingClient second(kSensor, PairMethod::kCode, Role::kAdmin, kCode);
  EXPECT_EQ(run(second).result, PairResult::kFull);
}

TEST_F(PairingServerTest, WhoBeginsAgainAndAgainIsHeldBack) {
  int begun = 0;
  for (int i = 0; i < 1000; ++i) {
    now_ += PairingServer::kKnownTime + 1ms;
    PairingClient client(kSensor, PairMethod::kCode, Role::kAdmin, kCode);
    begun += ask(client.begin()).result == PairResult::kOk ? 1 : 0;
  }
  EXPECT_EQ(begun, 1000);
  begun = 0;
  now_ += PairingServer::kKnownTime;
  for (int i = 0; i < 1000; ++i) {
    now_ += 1ms;
    PairingClient client(kSensor, PairMethod::kCode, Role::kAdmin, kCode);
    const PairAnswer answer = ask(client.begin());
    if (answer.result == PairResult::kOk) {
      ++begun;
      PairRequest confirm = client.confirm();  // ends it
      confirm.attempt = answer.attempt;
      static_cast<void>(ask(confirm));
    }
  }
  EXPECT_LE(begun, 32);
  EXPECT_GE(begun, 25);
}

// Who sits between both ends and runs the protocol with each of them.
TEST_F(PairingServerTest, AMiddlemanIsSeenInTheDigits) {
  constexpr int kTries = 10'000;
  int equal = 0;
  for (int i = 0; i < kTries; ++i) {
    now_ += 200ms;
    server_.open(now_);
    PairingClient victim(kSensor, PairMethod::kDigits, Role::kAdmin);
    const PairRequest heard = victim.begin();
    // To the sensor he is a client, and bound before he has seen anything of it.
    PairingClient attacker(kSensor, PairMethod::kDigits, Role::kAdmin);
    const PairAnswer begun = ask(attacker.begin());
    ASSERT_EQ(begun.result, PairResult::kOk);
    // To the victim he is the sensor: with a key of his own, the true nonce or any.
    const wire::Exchange own;
    PairAnswer told = begun;
    wire::put_bytes(own.public_key(), told.value);
    static_cast<void>(victim.reveal(told));
    ASSERT_EQ(ask(attacker.reveal(begun)).result, PairResult::kOk);
    const std::uint32_t at_sensor = server_.digits().value();
    EXPECT_EQ(at_sensor, attacker.secrets().digits());
    equal += at_sensor == victim.secrets().digits() ? 1 : 0;
    // What he passes on instead: the victim's commitment does not fit his key.
    ASSERT_NE(wire::bytes_in<wire::Digest>(heard.value),
              wire::commitment_of(attacker.said().client_key, attacker.said().client_nonce));
  }
  EXPECT_LE(equal, 1);  // by chance 0.01
}

TEST_F(PairingServerTest, WhatIsAskedForIsToldWithTheDigits) {
  firmware::ChangeRing changes;
  server_.set_changes(&changes);
  const auto told = [&] {
    server_.tick(now_);
    return changes.pop();
  };
  EXPECT_FALSE(told());
  server_.open(now_);
  EXPECT_EQ(told()->value, firmware::kPairingOpen);
  EXPECT_FALSE(told());  // once
  from_.address = {0xFD, 1, 2};
  PairingClient client(kSensor, PairMethod::kDigits, Role::kTune);
  const PairRequest begin = client.begin();
  const PairAnswer begun = ask(begin);
  // Whoever repeats what he heard is not who began.
  const hal::Peer own = std::exchange(from_, {.address = {0xFD, 6, 6}});
  ASSERT_EQ(ask(begin).attempt, begun.attempt);
  from_ = own;
  ASSERT_EQ(ask(client.reveal(begun)).result, PairResult::kOk);
  // What finds no room is told when there is some.
  while (changes.push({.kind = firmware::EventKind::kSettingsChanged})) {
  }
  server_.tick(now_);
  while (changes.pop()) {
  }
  const auto digits = told();
  ASSERT_TRUE(digits);
  EXPECT_EQ(digits->kind, firmware::EventKind::kPairing);
  EXPECT_EQ(digits->value, firmware::kPairingTold + client.secrets().digits());
  EXPECT_EQ(digits->role, Role::kTune);
  EXPECT_EQ(digits->address, own.address);
  EXPECT_FALSE(told());
  hold();
  ASSERT_EQ(ask(client.confirm()).result, PairResult::kOk);
  EXPECT_EQ(told()->kind, firmware::EventKind::kKeyMade);
  const auto done = told();
  ASSERT_TRUE(done);
  EXPECT_EQ(done->value, firmware::kPairingDone);
  EXPECT_EQ(done->role, Role::kNone);
  now_ += PairingServer::kWindow;
  EXPECT_FALSE(told());  // that it is over was told
  server_.open(now_);
  EXPECT_EQ(told()->value, firmware::kPairingOpen);
  now_ += PairingServer::kWindow;
  EXPECT_EQ(told()->value, firmware::kPairingClosed);
}

TEST_F(PairingServerTest, AnotherRoleThanItsClientAskedForMakesOtherDigits) {
  int equal = 0;
  for (int i = 0; i < 4; ++i) {
    server_.open(now_);
    PairingClient client(kSensor, PairMethod::kDigits, Role::kView);
    PairRequest begin = client.begin();
    begin.role = Role::kAdmin;  // by who stands between
    const PairAnswer revealed = ask(client.reveal(ask(begin)));
    EXPECT_EQ(server_.asked_role(), Role::kAdmin);
    EXPECT_NE(wire::bytes_in<wire::Tag>(revealed.value), client.secrets().sensor_tag());
    equal += server_.digits() == client.secrets().digits() ? 1 : 0;
    now_ += 1s;
  }
  EXPECT_LE(equal, 1);  // by chance 4e-6
}

TEST(PairingNoHeap, AllocatesNothing) {
  ASSERT_TRUE(wire::start_crypto());
  const int before = test::allocations;
  Keyring ring(nullptr, nullptr);
  PairingServer server(kSensor, ring, kCode);
  for (const PairMethod method : {PairMethod::kDigits, PairMethod::kCode}) {
    server.open(hal::Time(1s));
    PairingClient client(kSensor, method, Role::kAdmin,
                         method == PairMethod::kCode ? std::span<const std::byte>(kCode)
                                                     : std::span<const std::byte>());
    const auto ask = [&](const PairRequest& request) {
      return server.serve(request, PairingWay::kNetwork, hal::Time(1s));
    };
    static_cast<void>(ask(client.reveal(ask(client.begin()))));
    server.tick(hal::Time(1s));
    server.hold(hal::Time(1s));
    ASSERT_EQ(ask(client.confirm()).result, PairResult::kOk);
  }
  EXPECT_EQ(test::allocations, before);
}

}  // namespace
}  // namespace stof::keys
