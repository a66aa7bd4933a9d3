#include <algorithm>
#include <cstdint>
#include <optional>
#include <vector>

#include <gtest/gtest.h>

#include "firmware/events/event_values.h"
#include "firmware/keys/button_watcher.h"
#include "firmware/keys/pairing_server.h"
#include "hal/emu/devices/button.h"
#include "tests/firmware/keys/pairing_client.h"
#include "tests/firmware/keys/pairing_server_fixture.h"

namespace stof::keys {
namespace {

using namespace std::chrono_literals;
using firmware::kPairingClosed;
using firmware::kPairingHeldInVain;
using firmware::kPairingOpen;
using firmware::kPairingPressed;
using test::PairingClient;
using wire::PairMethod;
using wire::PairResult;
using wire::Role;

hal::Time button_time{1000s};
hal::Time read_button_time() noexcept { return button_time; }

// Somebody at the sensor with its button, whose time passes as he reads and holds; strangers and an
// owner on the network.
class PairingButtonTest : public PairingServerTest {
 protected:
  void SetUp() override {
    PairingServerTest::SetUp();
    server_.set_changes(&changes_);
    pass(1s);
  }
  // As the control thread looks at it, which tells as well.
  void pass(hal::Duration time) {
    for (const hal::Time end = button_time + time; button_time < end; button_time += 20ms) {
      now_ = button_time;
      server_.take(watcher_, now_);
      server_.tick(now_);
      while (const auto event = changes_.pop()) {
        told_.push_back(*event);
      }
    }
  }
  void press_for(hal::Duration time) {
    button_.press(time);
    pass(time + 500ms);
  }
  bool told(std::uint32_t state, std::uint32_t former) const {
    return std::ranges::any_of(told_, [&](const firmware::Event& event) {
      return event.kind == firmware::EventKind::kPairing && event.value == state &&
             event.former == former;
    });
  }
  // Of this client, as event_values.h has them.
  static std::uint32_t digits_of(const PairingClient& client) {
    return firmware::kPairingTold + client.secrets().digits();
  }
  // Both have revealed.
  void begin(PairingClient& client) {
    ASSERT_EQ(ask(client.reveal(ask(client.begin()))).result, PairResult::kOk);
  }

  firmware::ChangeRing changes_;
  hal::emu::Button button_{&read_button_time};
  ButtonWatcher watcher_{button_};
  std::vector<firmware::Event> told_;
  PairingClient owner_{kSensor, PairMethod::kDigits, Role::kAdmin};
  PairingClient stranger_{kSensor, PairMethod::kDigits, Role::kAdmin};
};

TEST_F(PairingButtonTest, APressOpensAndAHoldAcceptsWhatWasTold) {
  press_for(300ms);
  ASSERT_TRUE(server_.is_open());
  begin(owner_);
  pass(1s);
  ASSERT_TRUE(told(digits_of(owner_), 0));
  ASSERT_EQ(ask(owner_.confirm()).result, PairResult::kWaiting);
  press_for(3500ms);
  EXPECT_EQ(ask(owner_.confirm()).result, PairResult::kOk);
  EXPECT_EQ(ring_.keys().count(), 1U);
  EXPECT_FALSE(told(digits_of(owner_), kPairingHeldInVain));
}

// A hold that was too short is a press. It ends the owner's attempt and opens nothing: else a
// stranger who polls had his own digits told just before the owner holds again.
TEST_F(PairingButtonTest, AHoldThatWasTooShortEndsTheAttemptAndOpensNothing) {
  press_for(300ms);
  begin(owner_);
  pass(1s);
  ASSERT_EQ(ask(owner_.confirm()).result, PairResult::kWaiting);
  press_for(2500ms);
  EXPECT_FALSE(server_.is_open());
  EXPECT_TRUE(told(kPairingClosed, kPairingPressed));
  EXPECT_EQ(ask(owner_.confirm()).result, PairResult::kWrong);
  EXPECT_EQ(ask(stranger_.begin()).result, PairResult::kClosed);
  press_for(3500ms);  // the owner's second, longer hold
  EXPECT_TRUE(told(kPairingClosed, kPairingHeldInVain));
  EXPECT_EQ(ask(stranger_.begin()).result, PairResult::kClosed);
  EXPECT_EQ(ring_.keys().count(), 0U);
  press_for(300ms);  // and only a press opens again
  EXPECT_TRUE(server_.is_open());
  begin(owner_);
  pass(1s);
  ASSERT_EQ(ask(owner_.confirm()).result, PairResult::kWaiting);
  press_for(3500ms);
  EXPECT_EQ(ask(owner_.confirm()).result, PairResult::kOk);
}

// Before the press, or between its begin and its end: the owner cannot know.
TEST_F(PairingButtonTest, AHoldThatWasTooShortOpensNothingWhereAStrangerHasEndedTheAttempt) {
  for (const bool within : {false, true}) {
    told_.clear();
    press_for(300ms);
    ASSERT_TRUE(server_.is_open());
    begin(owner_);
    pass(1s);
    if (within) {
      button_.press(2500ms);
      pass(1s);
    }
    ASSERT_EQ(ask(stranger_.begin()).result, PairResult::kBusy);  // both have ended
    within ? pass(2s) : press_for(2500ms);
    EXPECT_FALSE(server_.is_open());
    EXPECT_TRUE(told(kPairingClosed, kPairingPressed));
    EXPECT_EQ(ask(stranger_.begin()).result, PairResult::kClosed);
    press_for(3500ms);  // the owner's second, longer hold
    EXPECT_TRUE(told(kPairingClosed, kPairingHeldInVain));
    EXPECT_EQ(ring_.keys().count(), 0U);
  }
  press_for(300ms);
  EXPECT_TRUE(server_.is_open());
}

TEST_F(PairingButtonTest, TwoMinutesAfterAnAttemptThatWasCutAPressOpens) {
  press_for(300ms);
  begin(owner_);
  pass(1s);
  ASSERT_EQ(ask(stranger_.begin()).result, PairResult::kBusy);
  pass(PairingServer::kWindow + 1s);
  press_for(300ms);
  EXPECT_TRUE(server_.is_open());
}

TEST_F(PairingButtonTest, APressEndsAnAttemptWhoseDigitsAreNotToldYet) {
  press_for(300ms);
  ASSERT_EQ(ask(stranger_.begin()).result, PairResult::kOk);
  press_for(300ms);
  EXPECT_FALSE(server_.is_open());
  press_for(300ms);
  EXPECT_TRUE(server_.is_open());
  told_.clear();
  press_for(300ms);  // nobody has come: another two minutes
  EXPECT_TRUE(server_.is_open());
  EXPECT_TRUE(told(kPairingOpen, 0));
}

// Nobody can have read the digits before he began to hold.
TEST_F(PairingButtonTest, AHoldThatBeganBeforeTheDigitsWereToldAcceptsNothing) {
  press_for(300ms);
  button_.press(3500ms);
  pass(2900ms);
  begin(stranger_);
  ASSERT_EQ(ask(stranger_.confirm()).result, PairResult::kWaiting);
  pass(2s);
  EXPECT_EQ(ask(stranger_.confirm()).result, PairResult::kWaiting);
  EXPECT_EQ(ring_.keys().count(), 0U);
  EXPECT_TRUE(told(digits_of(stranger_), kPairingHeldInVain));
  press_for(3500ms);  // who has read them holds again
  EXPECT_EQ(ask(stranger_.confirm()).result, PairResult::kOk);
}

TEST_F(PairingButtonTest, AHoldBeforeAnyDigitsAcceptsNoneThatFollow) {
  press_for(300ms);
  button_.press(10s);
  pass(4s);
  EXPECT_TRUE(told(kPairingOpen, kPairingHeldInVain));
  begin(stranger_);
  ASSERT_EQ(ask(stranger_.confirm()).result, PairResult::kWaiting);
  pass(8s);  // and lets go
  EXPECT_EQ(ask(stranger_.confirm()).result, PairResult::kWaiting);
  EXPECT_EQ(ring_.keys().count(), 0U);
}

// What one attempt was held for is nothing to the next one.
TEST_F(PairingButtonTest, AHoldThatGoesOnAcceptsNoOtherDigits) {
  press_for(300ms);
  begin(owner_);
  pass(1s);
  button_.press(10s);
  pass(1s);
  ASSERT_EQ(ask(stranger_.begin()).result, PairResult::kBusy);  // both have ended
  server_.open(now_);                                           // over the cable, meanwhile
  begin(stranger_);
  pass(10s);
  EXPECT_EQ(ask(stranger_.confirm()).result, PairResult::kWaiting);
  EXPECT_EQ(ring_.keys().count(), 0U);
}

// Digits that found no room among what is told are not told yet.
TEST_F(PairingButtonTest, DigitsThatWereNotToldAreNotAccepted) {
  press_for(300ms);
  begin(owner_);
  while (changes_.push({.kind = firmware::EventKind::kSettingsChanged})) {
  }
  server_.tick(now_);
  server_.hold(now_);
  ASSERT_EQ(ask(owner_.confirm()).result, PairResult::kWaiting);
  while (changes_.pop()) {
  }
  server_.tick(now_);
  server_.hold(now_);
  EXPECT_EQ(ask(owner_.confirm()).result, PairResult::kOk);
}

// The contacts' bouncing is no release, and what was held before the watcher came is none either.
TEST_F(PairingButtonTest, OnlyAButtonThatWasReleasedIsHeld) {
  const std::optional<hal::Time> released = watcher_.released_at();
  ASSERT_TRUE(released.has_value());
  button_.press(990ms);
  pass(1s);
  button_.press(2s);  // a gap of some milliseconds
  pass(1s);
  EXPECT_EQ(watcher_.released_at(), released);
  pass(2s);
  EXPECT_GT(watcher_.released_at(), released);
  server_.open(now_);
  begin(owner_);
  server_.tick(now_);
  server_.hold(std::nullopt);
  EXPECT_EQ(ask(owner_.confirm()).result, PairResult::kWaiting);
}

}  // namespace
}  // namespace stof::keys
