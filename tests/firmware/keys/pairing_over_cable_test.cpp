#include <gtest/gtest.h>

#include "firmware/keys/pairing_server.h"
#include "tests/firmware/keys/pairing_client.h"
#include "tests/firmware/keys/pairing_server_fixture.h"

namespace stof::keys {
namespace {

using namespace std::chrono_literals;
using test::PairingClient;
using wire::PairAnswer;
using wire::PairMethod;
using wire::PairRequest;
using wire::PairResult;
using wire::Role;

std::uint32_t digits_in(const PairAnswer& answer) {
  return wire::get_u32(std::as_bytes(std::span(answer.value)).first<4>());
}

TEST_F(PairingServerTest, TheCableOpensAndAcceptsForAnotherClient) {
  PairingClient holder(kSensor, PairMethod::kDigits, Role::kAdmin);
  const PairAnswer opened = ask(holder.open(), PairingWay::kCable);
  EXPECT_EQ(opened.result, PairResult::kOk);
  EXPECT_EQ(opened.key_id, 0U);
  EXPECT_TRUE(server_.is_open());
  from_.address = {0xFD, 1, 2};
  PairingClient client(kSensor, PairMethod::kDigits, Role::kTune);
  const PairAnswer begun = ask(client.begin());
  EXPECT_EQ(ask(holder.open(), PairingWay::kCable).result, PairResult::kOk);  // no digits yet
  ASSERT_EQ(ask(client.reveal(begun)).result, PairResult::kOk);
  const PairAnswer come = ask(holder.open(), PairingWay::kCable);
  EXPECT_EQ(come.result, PairResult::kWaiting);
  EXPECT_EQ(digits_in(come), client.secrets().digits());
  EXPECT_EQ(wire::offer_in(come.value).role, Role::kTune);
  EXPECT_EQ(wire::offer_in(come.value).from, from_.address);
  EXPECT_EQ(ask(holder.accept(digits_in(come)), PairingWay::kCable).result, PairResult::kWaiting);
  EXPECT_EQ(ring_.keys().count(), 0U);  // the client's user has said nothing
  EXPECT_EQ(ask(client.confirm()).result, PairResult::kOk);
  EXPECT_TRUE(has_key_of(client, begun.key_id));
  for (const PairRequest& again : {holder.open(), holder.accept(digits_in(come))}) {
    const PairAnswer done = ask(again, PairingWay::kCable);
    EXPECT_EQ(done.result, PairResult::kOk);
    EXPECT_EQ(done.key_id, begun.key_id);
  }
  EXPECT_EQ(ring_.keys().count(), 1U);
}

TEST_F(PairingServerTest, TheCableAcceptsAfterTheClientsUserAndWhatTheButtonOpened) {
  server_.open(now_);
  PairingClient client(kSensor, PairMethod::kDigits, Role::kAdmin);
  ASSERT_EQ(run(client).result, PairResult::kWaiting);
  PairingClient holder(kSensor, PairMethod::kDigits, Role::kAdmin);
  const PairAnswer done = ask(holder.accept(client.secrets().digits()), PairingWay::kCable);
  EXPECT_EQ(done.result, PairResult::kOk);
  EXPECT_TRUE(has_key_of(client, done.key_id));
}

TEST_F(PairingServerTest, WhoOpenedOverTheCableMayCloseBeforeDigitsAreThere) {
  for (const bool begun : {false, true}) {
    PairingClient holder(kSensor, PairMethod::kDigits, Role::kAdmin);
    ASSERT_EQ(ask(holder.open(), PairingWay::kCable).result, PairResult::kOk);
    PairingClient client(kSensor, PairMethod::kDigits, Role::kAdmin);
    if (begun) {
      ASSERT_EQ(ask(client.begin()).result, PairResult::kOk);
    }
    EXPECT_EQ(ask(holder.accept(1'000'000), PairingWay::kCable).result, PairResult::kWrong);
    EXPECT_FALSE(server_.is_open());
    EXPECT_EQ(ask(holder.open(), PairingWay::kCable).result, PairResult::kClosed);
    EXPECT_EQ(ask(client.begin()).result, PairResult::kClosed);
  }
}

TEST_F(PairingServerTest, OtherDigitsOverTheCableEndTheAttempt) {
  PairingClient holder(kSensor, PairMethod::kDigits, Role::kAdmin);
  EXPECT_EQ(ask(holder.accept(0), PairingWay::kCable).result, PairResult::kWrong);
  ASSERT_EQ(ask(holder.open(), PairingWay::kCable).result, PairResult::kOk);
  EXPECT_EQ(ask(holder.accept(0), PairingWay::kCable).result, PairResult::kWrong);
  EXPECT_TRUE(server_.is_open());  // nobody has come
  PairingClient client(kSensor, PairMethod::kDigits, Role::kAdmin);
  ASSERT_EQ(run(client).result, PairResult::kWaiting);
  const std::uint32_t other = (client.secrets().digits() + 1) % 1'000'000;
  EXPECT_EQ(ask(holder.accept(other), PairingWay::kCable).result, PairResult::kWrong);
  EXPECT_FALSE(server_.is_open());
  EXPECT_EQ(ask(client.confirm()).result, PairResult::kWrong);
  EXPECT_EQ(ask(holder.open(), PairingWay::kCable).result, PairResult::kClosed);
  EXPECT_EQ(ring_.keys().count(), 0U);
}

TEST_F(PairingServerTest, WhoAsksAgainOverTheCableOpensNothingNew) {
  PairingClient holder(kSensor, PairMethod::kDigits, Role::kAdmin);
  ASSERT_EQ(ask(holder.open(), PairingWay::kCable).result, PairResult::kOk);
  now_ += PairingServer::kWindow - 1ms;
  EXPECT_EQ(ask(holder.open(), PairingWay::kCable).result, PairResult::kOk);
  now_ += 1ms;
  EXPECT_EQ(ask(holder.open(), PairingWay::kCable).result, PairResult::kClosed);
  EXPECT_FALSE(server_.is_open());
  // Another opening is another two minutes, and nothing of the last ones.
  PairingClient next(kSensor, PairMethod::kDigits, Role::kAdmin);
  ASSERT_EQ(ask(next.open(), PairingWay::kCable).result, PairResult::kOk);
  PairingClient client(kSensor, PairMethod::kDigits, Role::kAdmin);
  ASSERT_EQ(run(client).result, PairResult::kWaiting);
  ASSERT_EQ(ask(holder.open(), PairingWay::kCable).result, PairResult::kOk);
  EXPECT_EQ(ask(client.confirm()).result, PairResult::kWrong);
}

TEST_F(PairingServerTest, NobodyOpensOrAcceptsOverTheNetwork) {
  PairingClient holder(kSensor, PairMethod::kDigits, Role::kAdmin);
  for (const PairMethod method : {PairMethod::kDigits, PairMethod::kCable, PairMethod::kCode}) {
    PairRequest open = holder.open();
    open.method = method;
    EXPECT_EQ(ask(open).result, PairResult::kClosed);
    EXPECT_FALSE(server_.is_open());
  }
  server_.open(now_);
  PairingClient client(kSensor, PairMethod::kDigits, Role::kAdmin);
  ASSERT_EQ(run(client).result, PairResult::kWaiting);
  const std::uint32_t digits = client.secrets().digits();
  const PairAnswer asked = ask(holder.open());
  EXPECT_EQ(asked.result, PairResult::kClosed);
  EXPECT_EQ(asked.value, PairAnswer{}.value);  // the digits are not told
  EXPECT_EQ(ask(holder.accept(digits)).result, PairResult::kClosed);
  EXPECT_EQ(ring_.keys().count(), 0U);
  EXPECT_EQ(ask(client.confirm()).result, PairResult::kWaiting);  // and it goes on
}

}  // namespace
}  // namespace stof::keys
