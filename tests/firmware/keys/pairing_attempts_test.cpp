#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <span>

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

// An owner who knows the label's code and key 5, and strangers who know that there are such.
class PairingAttemptsTest : public PairingServerTest {
 protected:
  void SetUp() override {
    PairingServerTest::SetUp();
    ASSERT_EQ(ring_.add(numbered_key(5)), Status::kOk);
  }
  static PairingClient stranger(PairMethod method) {
    static const wire::Secret guess{std::byte{1}};
    return {kSensor, method, Role::kAdmin, guess, method == PairMethod::kKey ? 5U : 0U};
  }
  PairingClient owner(PairMethod method) {
    switch (method) {
      case PairMethod::kCode:
        return {kSensor, method, Role::kAdmin, kCode};
      case PairMethod::kKey:
        secret_ = ring_.keys().find(5)->secret;
        return {kSensor, method, Role::kAdmin, secret_, 5};
      default:
        return {kSensor, method, Role::kAdmin};
    }
  }
  // More than a sensor begins, with and without steps that end an attempt.
  void flood() {
    for (int i = 0; i < 30; ++i) {
      for (const PairMethod method : {PairMethod::kCode, PairMethod::kKey}) {
        PairingClient one = stranger(method);
        if (i % 3 == 0) {
          one.prove_nothing();
        }
        const PairAnswer begun = ask(one.begin());
        if (begun.result == PairResult::kOk && i % 2 == 0) {
          static_cast<void>(ask(one.reveal(begun)));
          EXPECT_NE(ask(one.confirm()).result, PairResult::kOk);
        }
      }
    }
  }
  PairResult pair_among_strangers(PairMethod method, PairingWay way) {
    PairingClient client = owner(method);
    flood();
    const PairAnswer begun = ask(client.begin(), way);
    if (begun.result != PairResult::kOk) {
      return begun.result;
    }
    flood();
    EXPECT_EQ(ask(client.reveal(begun), way).result, PairResult::kOk);
    flood();
    const PairAnswer done = ask(client.confirm(), way);
    flood();
    EXPECT_EQ(ask(client.confirm(), way).result, done.result) << "its answer was lost";
    EXPECT_TRUE(has_key_of(client, done.key_id));
    return done.result;
  }

  wire::Secret secret_{};  // outlives the owner's client
};

TEST_F(PairingAttemptsTest, StrangersNeitherEndNorHoldUpARenewal) {
  for (int i = 0; i < 3; ++i) {
    EXPECT_EQ(pair_among_strangers(PairMethod::kKey, PairingWay::kNetwork), PairResult::kOk);
    ring_.settle(5);
    now_ += 1s;
  }
}

TEST_F(PairingAttemptsTest, StrangersNeitherEndNorHoldUpWhoKnowsTheCode) {
  EXPECT_EQ(pair_among_strangers(PairMethod::kCode, PairingWay::kNetwork), PairResult::kOk);
}

TEST_F(PairingAttemptsTest, StrangersNeitherEndNorHoldUpWhoHoldsTheCable) {
  EXPECT_EQ(pair_among_strangers(PairMethod::kCable, PairingWay::kCable), PairResult::kOk);
}

TEST_F(PairingAttemptsTest, StrangersWithAnotherMethodNeitherEndNorHoldUpWhoPairsByDigits) {
  server_.open(now_);
  PairingClient client = owner(PairMethod::kDigits);
  flood();
  const PairAnswer begun = ask(client.begin());
  flood();
  ASSERT_EQ(ask(client.reveal(begun)).result, PairResult::kOk);
  hold();
  flood();
  EXPECT_EQ(ask(client.confirm()).result, PairResult::kOk);
}

TEST_F(PairingAttemptsTest, OtherKeysNeitherEndNorHoldUpARenewal) {
  ASSERT_EQ(ring_.add(numbered_key(6, Role::kView)), Status::kOk);
  PairingClient client = owner(PairMethod::kKey);
  const PairAnswer begun = ask(client.begin());
  const wire::Secret others = numbered_key(6).secret;
  for (int i = 0; i < 50; ++i) {
    PairingClient other(kSensor, PairMethod::kKey, Role::kView, others, 6);
    static_cast<void>(ask(other.begin()));
  }
  ASSERT_EQ(ask(client.reveal(begun)).result, PairResult::kOk);
  EXPECT_EQ(ask(client.confirm()).result, PairResult::kOk);
}

TEST_F(PairingAttemptsTest, WhoKnowsTheKeyNeedNotWaitForWhatHeLeft) {
  PairingClient left = owner(PairMethod::kKey);
  ASSERT_EQ(ask(left.reveal(ask(left.begin()))).result, PairResult::kOk);
  PairingClient client = owner(PairMethod::kKey);
  EXPECT_EQ(run(client).result, PairResult::kOk);
  EXPECT_EQ(ask(left.confirm()).result, PairResult::kWrong);
  EXPECT_TRUE(has_key_of(client, 5));
}

// A datagram that the network delivers twice, also late, is no second client.
TEST_F(PairingAttemptsTest, ABeginThatComesLateIsAnsweredAsTheFirst) {
  server_.open(now_);
  for (const PairMethod method : {PairMethod::kDigits, PairMethod::kKey}) {
    PairingClient client = owner(method);
    const PairRequest begin = client.begin();
    const PairAnswer begun = ask(begin);
    ASSERT_EQ(ask(client.reveal(begun)).result, PairResult::kOk);
    const PairAnswer again = ask(begin);
    EXPECT_EQ(again.attempt, begun.attempt);
    EXPECT_EQ(again.value, begun.value);
    hold();
    EXPECT_EQ(ask(client.confirm()).result, PairResult::kOk);
  }
}

TEST_F(PairingAttemptsTest, TheProofIsOfThisRequestAlone) {
  PairingClient nobody = stranger(PairMethod::kCode);
  ASSERT_EQ(ask(nobody.begin()).result, PairResult::kOk);  // has the place of all who show nothing
  const std::function<void(PairRequest&)> changes[]{
      [](PairRequest& begin) { begin.cookie ^= 1; },
      [](PairRequest& begin) { begin.role = Role::kView; },
      [](PairRequest& begin) { begin.name[0] ^= 1; },
      [](PairRequest& begin) { begin.value[31] ^= 1; },
      [](PairRequest& begin) { begin.nonce[15] ^= 1; },
      [](PairRequest& begin) { begin.nonce = {}; }};
  for (const PairMethod method : {PairMethod::kCode, PairMethod::kKey}) {
    PairingClient client = owner(method);
    for (const auto& change : changes) {
      PairRequest begin = client.begin();
      change(begin);
      EXPECT_EQ(ask(begin).result, PairResult::kBusy);
    }
    EXPECT_EQ(ask(client.begin()).result, PairResult::kOk);
  }
}

// Of another program (Python's hashlib), made of docs/WIRE.md.
TEST(BeginProof, IsWhatTheDocumentSays) {
  wire::Secret known{};
  PairRequest begin{.method = PairMethod::kKey,
                    .role = Role::kTune,
                    .cookie = 0x1122334455667788,
                    .key_id = 5,
                    .name = {'a', 'n', 'n'}};
  for (std::size_t i = 0; i < known.size(); ++i) {
    known[i] = static_cast<std::byte>(i);
    begin.value[i] = static_cast<std::uint8_t>(100 + i);
  }
  constexpr std::array<std::uint8_t, 16> kProof{0x40, 0xEC, 0x09, 0x4D, 0x4B, 0xE0, 0x0C, 0xEC,
                                                0x11, 0x60, 0xE9, 0xC9, 0xA4, 0x1D, 0x57, 0xF4};
  EXPECT_TRUE(
      std::ranges::equal(wire::begin_proof(known, begin), std::as_bytes(std::span(kProof))));
}

TEST_F(PairingAttemptsTest, ClientsThatAreOlderThanTheProofPairAsBefore) {
  for (const PairMethod method : {PairMethod::kCode, PairMethod::kKey}) {
    PairingClient client = owner(method);
    client.prove_nothing();
    EXPECT_EQ(run(client).result, PairResult::kOk);
  }
  // Of keys that are not there nothing begins, whatever is shown.
  PairingClient nobodys(kSensor, PairMethod::kKey, Role::kAdmin, numbered_key(7).secret, 7);
  EXPECT_EQ(ask(nobodys.begin()).result, PairResult::kClosed);
}

}  // namespace
}  // namespace stof::keys
