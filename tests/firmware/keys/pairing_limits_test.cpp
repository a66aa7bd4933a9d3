#include <gtest/gtest.h>

#include "firmware/keys/pairing_server.h"
#include "tests/firmware/keys/pairing_client.h"
#include "tests/firmware/keys/pairing_server_fixture.h"
#include "tests/firmware/keys/some_keys.h"

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

// The event of the new key is for all to hear: who begins, or guesses, in that moment must not
// leave a key that its client believes refused.
TEST_F(PairingServerTest, OnceAKeyIsMadeNobodyKeepsItsClientFromHearingOfIt) {
  server_.open(now_);
  PairingClient owner(kSensor, PairMethod::kDigits, Role::kAdmin);
  ASSERT_EQ(run(owner).result, PairResult::kWaiting);
  hold();
  ASSERT_EQ(ring_.keys().count(), 1U);
  PairingClient stranger(kSensor, PairMethod::kDigits, Role::kAdmin);
  EXPECT_EQ(ask(stranger.begin()).result, PairResult::kClosed);
  PairRequest guess = owner.confirm();
  guess.value[0] ^= 1;
  EXPECT_EQ(ask(guess).result, PairResult::kWrong);
  const PairAnswer done = ask(owner.confirm());
  EXPECT_EQ(done.result, PairResult::kOk);
  EXPECT_EQ(wire::bytes_in<wire::Tag>(done.value), owner.secrets().done_tag());
  now_ += PairingServer::kWindow;
  EXPECT_EQ(ask(owner.confirm()).result, PairResult::kWrong);
  EXPECT_EQ(ring_.keys().count(), 1U);
}

// Each is two files of flash: whoever has any key, or the code, must not wear it out.
TEST_F(PairingServerTest, RenewsAKeyTenTimesThenOnceAnHour) {
  const wire::Key mine = numbered_key(5, Role::kView);
  const wire::Key others = numbered_key(6, Role::kAdmin);
  ASSERT_EQ(ring_.add(mine), Status::kOk);
  ASSERT_EQ(ring_.add(others), Status::kOk);
  const auto renew = [&](std::uint32_t id) {
    const wire::Secret secret = ring_.keys().find(id)->secret;
    PairingClient client(kSensor, PairMethod::kKey, Role::kView, secret, id);
    const PairResult result = run(client).result;
    if (result == PairResult::kOk) {
      ring_.settle(id);  // as the first request does that the new secret signs
    }
    now_ += 11s;  // the attempt of before is over
    return result;
  };
  for (std::uint32_t i = 0; i < KeyWriteLimiter::kMostWrites; ++i) {
    ASSERT_EQ(renew(5), PairResult::kOk) << i;
  }
  const int saves = store_.saves();
  EXPECT_EQ(renew(5), PairResult::kLater);
  EXPECT_EQ(renew(5), PairResult::kLater);
  EXPECT_EQ(renew(6), PairResult::kOk) << "another key is not kept from it";
  now_ += KeyWriteLimiter::kRefill;
  EXPECT_EQ(renew(5), PairResult::kOk);
  EXPECT_EQ(renew(5), PairResult::kLater);
  EXPECT_EQ(store_.saves() - saves, 4) << "two renewals, and each one's end of the old secret";
  EXPECT_EQ(ring_.remove(5), Status::kOk) << "the end of a key is never too often";
}

TEST_F(PairingServerTest, TheCodeMakesTenKeysThenOneAnHourAndTheButtonAtAnyTime) {
  const auto make = [&](PairMethod method) {
    PairingClient client(kSensor, method, Role::kView,
                         method == PairMethod::kCode ? std::span<const std::byte>(kCode)
                                                     : std::span<const std::byte>{});
    const PairAnswer last = run(client);
    if (last.result == PairResult::kOk) {
      EXPECT_EQ(ring_.remove(last.key_id), Status::kOk);
    }
    now_ += 11s;
    return last.result;
  };
  for (std::uint32_t i = 0; i < KeyWriteLimiter::kMostWrites; ++i) {
    ASSERT_EQ(make(PairMethod::kCode), PairResult::kOk) << i;
  }
  EXPECT_EQ(make(PairMethod::kCode), PairResult::kLater);
  server_.open(now_);
  EXPECT_EQ(make(PairMethod::kDigits), PairResult::kWaiting);
  now_ += KeyWriteLimiter::kRefill;
  EXPECT_EQ(make(PairMethod::kCode), PairResult::kOk);
}

// Who only says a key's number, or guesses, takes nothing of whoever has it.
TEST_F(PairingServerTest, WhoProvesNothingUsesUpNoRenewal) {
  ASSERT_EQ(ring_.add(numbered_key(5)), Status::kOk);
  for (std::uint32_t i = 0; i < 2 * KeyWriteLimiter::kMostWrites; ++i) {
    PairingClient stranger(kSensor, PairMethod::kKey, Role::kAdmin, wire::Secret{}, 5);
    const PairAnswer begun = ask(stranger.begin());
    ASSERT_EQ(begun.result, PairResult::kOk);
    ASSERT_EQ(ask(stranger.reveal(begun)).result, PairResult::kOk);
    ASSERT_EQ(ask(stranger.confirm()).result, PairResult::kWrong);
    now_ += 11s;
  }
  PairingClient owner(kSensor, PairMethod::kKey, Role::kAdmin, ring_.keys().find(5)->secret, 5);
  EXPECT_EQ(run(owner).result, PairResult::kOk);
}

// While a renewal goes on, its key is ended and another takes its place: nothing is written.
TEST_F(PairingServerTest, AKeyThatIsEndedWhileItIsRenewedIsNotRenewed) {
  for (std::uint32_t id = 1; id <= kMostKeys; ++id) {
    ASSERT_EQ(ring_.add(numbered_key(id)), Status::kOk);
    PairingClient client(kSensor, PairMethod::kKey, Role::kAdmin, numbered_key(id).secret, id);
    ASSERT_EQ(ask(client.begin()).result, PairResult::kOk);
    now_ += 11s;
  }
  const int saves = store_.saves();
  std::uint32_t id = 1;
  // The newcomer's place is that of the key that has gone; clients that show nothing share one.
  for (const bool proves : {true, false}) {
    const wire::Key gone = numbered_key(id);
    const wire::Key next = numbered_key(98 + id);
    PairingClient ended(kSensor, PairMethod::kKey, Role::kAdmin, gone.secret, gone.id);
    PairingClient newcomer(kSensor, PairMethod::kKey, Role::kAdmin, next.secret, next.id);
    if (!proves) {
      ended.prove_nothing();
      newcomer.prove_nothing();
    }
    ASSERT_EQ(ask(ended.reveal(ask(ended.begin()))).result, PairResult::kOk);
    ASSERT_EQ(ring_.remove(gone.id), Status::kOk);
    ASSERT_EQ(ring_.add(next), Status::kOk);
    EXPECT_EQ(ask(newcomer.begin()).result, proves ? PairResult::kOk : PairResult::kBusy);
    EXPECT_EQ(ask(ended.confirm()).result, PairResult::kWrong);
    EXPECT_EQ(ring_.keys().find(gone.id), nullptr);
    ++id;
  }
  EXPECT_EQ(store_.saves(), saves + 4) << "of the keys that went and came";
}

TEST_F(PairingServerTest, ASensorThatKeepsNoMoreKeysSaysSoAtBegin) {
  for (std::uint32_t id = 1; id <= kMostKeys; ++id) {
    ASSERT_EQ(ring_.add(numbered_key(id)), Status::kOk);
  }
  server_.open(now_);
  for (const PairMethod method : {PairMethod::kDigits, PairMethod::kCode, PairMethod::kCable}) {
    PairingClient client(kSensor, method, Role::kAdmin, kCode);
    EXPECT_EQ(ask(client.begin(), PairingWay::kCable).result, PairResult::kFull);
  }
  EXPECT_TRUE(server_.is_open()) << "one may be ended meanwhile";
  PairingClient renewal(kSensor, PairMethod::kKey, Role::kAdmin, numbered_key(3).secret, 3);
  EXPECT_EQ(run(renewal).result, PairResult::kOk);
}

TEST_F(PairingServerTest, AKeyThatCannotBeSavedIsToldAfterTheHoldToo) {
  server_.open(now_);
  PairingClient client(kSensor, PairMethod::kDigits, Role::kAdmin);
  ASSERT_EQ(run(client).result, PairResult::kWaiting);
  store_.break_down(true);
  hold();
  EXPECT_EQ(ask(client.confirm()).result, PairResult::kFull);
  EXPECT_EQ(ask(client.confirm()).result, PairResult::kFull);
  EXPECT_EQ(ring_.keys().count(), 0U);
}

}  // namespace
}  // namespace stof::keys
