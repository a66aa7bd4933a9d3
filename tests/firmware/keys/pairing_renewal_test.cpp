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
using wire::PairResult;
using wire::Role;

// A key whose secret has leaked: its owner renews it, and whoever has the secret tries to, too.
class PairingRenewalTest : public PairingServerTest {
 protected:
  void SetUp() override {
    PairingServerTest::SetUp();
    ASSERT_EQ(ring_.add(numbered_key(5)), Status::kOk);
  }
  static PairingClient with(const wire::Secret& secret) {
    return {kSensor, PairMethod::kKey, Role::kAdmin, secret, 5};
  }
  const wire::Secret leaked_ = numbered_key(5).secret;
};

TEST_F(PairingRenewalTest, WhatBeganWithASecretThatIsNoneAnyMoreIsNotAccepted) {
  for (const bool proves : {false, true}) {
    ASSERT_EQ(ring_.remove(5), Status::kOk);
    ASSERT_EQ(ring_.add(numbered_key(5)), Status::kOk);
    PairingClient owner = with(leaked_);
    PairingClient thief = with(leaked_);
    if (proves) {  // between the owner's "done" and his first signature
      ASSERT_EQ(run(owner).result, PairResult::kOk);
    } else {
      thief.prove_nothing();
    }
    ASSERT_EQ(ask(thief.reveal(ask(thief.begin()))).result, PairResult::kOk);
    if (!proves) {
      ASSERT_EQ(run(owner).result, PairResult::kOk);
    }
    ring_.settle(5);
    EXPECT_EQ(ask(thief.confirm()).result, PairResult::kWrong);
    EXPECT_TRUE(has_key_of(owner, 5));
    EXPECT_FALSE(ring_.keys().find(5)->former.has_value());
  }
}

TEST_F(PairingRenewalTest, NorIsWhatBeganBeforeTheNewSecretRenewed) {
  PairingClient first = with(leaked_);
  ASSERT_EQ(run(first).result, PairResult::kOk);
  PairingClient thief = with(leaked_);
  thief.prove_nothing();
  ASSERT_EQ(ask(thief.reveal(ask(thief.begin()))).result, PairResult::kOk);
  const wire::Secret newest = first.secrets().secret();
  PairingClient second = with(newest);
  ASSERT_EQ(run(second).result, PairResult::kOk);
  EXPECT_EQ(ask(thief.confirm()).result, PairResult::kWrong);
  EXPECT_TRUE(has_key_of(second, 5));
}

TEST_F(PairingRenewalTest, TheNewSecretRenewsBeforeItHasSignedAndEndsTheOneOfBefore) {
  PairingClient lost = with(leaked_);
  ASSERT_EQ(run(lost).result, PairResult::kOk);
  const wire::Secret newest = lost.secrets().secret();
  PairingClient stranger = with(wire::Secret{std::byte{1}});
  ASSERT_EQ(ask(stranger.begin()).result, PairResult::kOk);  // has the place of who shows nothing
  PairingClient again = with(newest);
  EXPECT_EQ(run(again).result, PairResult::kOk);
  EXPECT_TRUE(has_key_of(again, 5));
  EXPECT_EQ(ring_.keys().find(5)->former, newest);
  PairingClient thief = with(leaked_);
  EXPECT_EQ(ask(thief.begin()).result, PairResult::kBusy) << "shows nothing";
}

TEST_F(PairingRenewalTest, AKeyThatWasEndedSinceIsNotSaidToBeInForce) {
  PairingClient owner = with(leaked_);
  ASSERT_EQ(run(owner).result, PairResult::kOk);
  ASSERT_EQ(ring_.remove(5), Status::kOk);
  EXPECT_EQ(ask(owner.confirm()).result, PairResult::kClosed);
}

TEST_F(PairingRenewalTest, StepsFromAnotherAddressEndNothing) {
  server_.open(now_);
  const hal::Peer own{.address = {1}, .port = 1};
  const hal::Peer other{.address = {2}, .port = 1};
  for (const PairMethod method : {PairMethod::kKey, PairMethod::kCode, PairMethod::kDigits}) {
    from_ = own;
    PairingClient client =
        method == PairMethod::kKey
            ? with(leaked_)
            : PairingClient(kSensor, method, Role::kAdmin,
                            method == PairMethod::kCode ? std::span<const std::byte>(kCode)
                                                        : std::span<const std::byte>());
    const PairAnswer begun = ask(client.begin());
    wire::PairRequest bad = client.reveal(begun);
    bad.nonce[0] ^= 1;
    from_ = other;
    EXPECT_EQ(ask(bad).result, PairResult::kWrong);
    from_ = own;
    ASSERT_EQ(ask(client.reveal(begun)).result, PairResult::kOk);
    wire::PairRequest confirm = client.confirm();
    confirm.value[0] ^= 1;
    from_ = other;
    EXPECT_EQ(ask(confirm).result, PairResult::kWrong);
    EXPECT_EQ(ask(client.confirm()).result, PairResult::kWrong) << "who overhears all of it";
    from_ = own;
    hold();
    EXPECT_EQ(ask(client.confirm()).result, PairResult::kOk);
  }
}

}  // namespace
}  // namespace stof::keys
