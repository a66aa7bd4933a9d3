#include <array>
#include <chrono>
#include <string>
#include <string_view>

#include <gtest/gtest.h>

#include "firmware/events/event_values.h"
#include "firmware/settings/fields/network_text.h"
#include "firmware/settings/network_trial.h"
#include "firmware/settings/saved_settings.h"
#include "firmware/settings/settings_server.h"
#include "firmware/settings/text/as_text.h"
#include "hal/emu/devices/store.h"
#include "tests/firmware/settings/settings_server_fixture.h"

namespace stof::settings {
namespace {

using namespace std::chrono_literals;

TEST(NetworkText, AnAddressIsFourPlainNumbers) {
  EXPECT_EQ(parse_ipv4("192.168.7.2"), 0xC0A8'0702U);
  EXPECT_EQ(parse_ipv4("0.0.0.0"), 0U);
  for (const char* const wrong :
       {"", "1", "1.2.3", "1.2.3.4.5", "1.2.3.256", "1.2.3.-4", "01.2.3.4", "1.2.3.04", "1..2.3",
        "1.2.3.", ".1.2.3", "1.2.3.4 ", "1.2.3.4x", "0x1.2.3.4", "1.2.3.4294967297"}) {
    EXPECT_FALSE(parse_ipv4(wrong)) << wrong;
  }
}

TEST(NetworkText, AnInterfaceHasTheAddressOfAHost) {
  const auto found = parse_interface_address("10.1.2.3/8");
  ASSERT_TRUE(found);
  EXPECT_EQ(found->address, 0x0A01'0203U);
  EXPECT_EQ(found->prefix_bits, 8);
  EXPECT_TRUE(parse_interface_address("192.168.7.1/30"));
  for (const char* const wrong :
       {"", "192.168.7.2", "192.168.7.2/", "192.168.7.2/7", "192.168.7.2/31", "192.168.7.2/024",
        "192.168.7.2/24/24", "192.168.7.0/24", "192.168.7.255/24", "127.0.0.1/8", "0.1.2.3/8",
        "224.0.0.1/24", "255.255.255.254/24", "192.168.7.2/-8", "192.168.7.2 /24"}) {
    EXPECT_FALSE(parse_interface_address(wrong)) << wrong;
  }
}

TEST(NetworkText, AHostnameIsOneLabel) {
  for (const char* const good : {"a", "stof", "front-7", "7"}) {
    EXPECT_TRUE(is_hostname(good)) << good;
  }
  for (const char* const wrong : {"", "-a", "a-", "a b", "a.b", "A", "a_b", "a\n", "\xC3\xA4"}) {
    EXPECT_FALSE(is_hostname(wrong)) << wrong;
  }
  EXPECT_TRUE(is_hostname(std::string(63, 'a')));
  EXPECT_FALSE(is_hostname(std::string(64, 'a')));
}

// stofd's other side carries out what it is asked for, when the test says so.
class NetworkSettingsTest : public SettingsServerTest {
 protected:
  static constexpr const char* kFixed = R"({"network": {"address": "192.168.7.2/24"}})";

  NetworkSettingsTest() { EXPECT_TRUE(trial_of_network_.begin({})); }

  std::string wanted() {
    std::array<std::byte, 512> bytes;
    const auto loaded = wanted_.load(bytes);
    return loaded && *loaded ? std::string(as_text(std::span(bytes).first(**loaded))) : "";
  }
  void carry_out() { done_.bytes() = wanted_.bytes(); }
  // Time passes, tick by tick.
  void pass(hal::Duration time) {
    constexpr hal::Duration kTick = 100ms;
    for (hal::Duration left = time; left > hal::Duration::zero(); left -= kTick) {
      now_ += kTick;
      networked_.tick(now_);
    }
  }
  Answer tell(Operation operation, const std::string& text = "") {
    std::array<std::byte, 1024> space;
    std::size_t bytes = 0;
    const wire::SettingsAnswer answer = networked_.serve(
        {.operation = operation}, std::as_bytes(std::span(text)),
        {.peer = over_line_ ? std::nullopt : std::optional(peer_), .now = now_, .access = access_},
        space, bytes);
    return {answer.result, std::string(as_text(std::span(space).first(bytes))), answer};
  }
  std::string address() const { return std::string(networked_.active().network.address.view()); }
  std::string saved_address() {
    std::array<char, kWhyBytes> why_space;
    PagedWriter why(why_space);
    Settings saved;
    std::array<std::byte, kMostDocumentBytes> bytes;
    const auto loaded = store_.load(bytes);
    EXPECT_TRUE(loaded && *loaded && parse(as_text(std::span(bytes).first(**loaded)), saved, why));
    return std::string(saved.network.address.view());
  }

  bool over_line_ = false;
  hal::emu::Store wanted_;
  hal::emu::Store done_;
  NetworkTrial trial_of_network_{wanted_, done_};
  SettingsServer networked_{Settings{},
                            Settings{},
                            {.limits = board_,
                             .sink = board_,
                             .store = &store_,
                             .fixed = &fixed_,
                             .changes = &changes_,
                             .network = &trial_of_network_}};
};

TEST_F(NetworkSettingsTest, AStartHandsThemOverAtOnce) {
  EXPECT_EQ(wanted(), "dhcp yes\nlink_local yes\nhostname stof\n");
  EXPECT_FALSE(trial_of_network_.runs());
}

TEST_F(NetworkSettingsTest, AChangeWaitsForItsAnswerToLeave) {
  const Answer answer = tell(
      Operation::kSet,
      R"({"network": {"dhcp": false, "address": "192.168.7.2/24", "gateway": "192.168.7.1", "hostname": "front"}})");
  EXPECT_EQ(answer.result, Result::kOk);
  EXPECT_NE(answer.text.find("for one minute"), std::string::npos) << answer.text;
  networked_.tick(now_);
  EXPECT_EQ(wanted(), "dhcp yes\nlink_local yes\nhostname stof\n");
  pass(NetworkTrial::kAnswerTime);
  EXPECT_EQ(wanted(),
            "dhcp no\nlink_local yes\naddress 192.168.7.2/24\ngateway 192.168.7.1\nhostname "
            "front\n");
}

TEST_F(NetworkSettingsTest, AChangeThatNobodySavesIsTakenBackAndTold) {
  carry_out();
  const std::string before = wanted();
  ASSERT_EQ(tell(Operation::kSet, kFixed).result, Result::kOk);
  EXPECT_EQ(changes_.pop()->former, firmware::kNetworkOnTrial);
  pass(NetworkTrial::kAnswerTime);
  carry_out();
  EXPECT_NE(wanted(), before);
  pass(NetworkTrial::kConfirmTime - 100ms);
  EXPECT_EQ(address(), "192.168.7.2/24");
  EXPECT_FALSE(changes_.pop());
  pass(100ms);
  EXPECT_EQ(address(), "");
  const auto told = changes_.pop();
  ASSERT_TRUE(told);
  EXPECT_EQ(told->kind, firmware::EventKind::kSettingsChanged);
  EXPECT_EQ(told->former, firmware::kNetworkTakenBack);
  EXPECT_EQ(told->value, 0U);
  pass(NetworkTrial::kAnswerTime + 100ms);
  EXPECT_EQ(wanted(), before);
  pass(10min);
  EXPECT_FALSE(changes_.pop());
  EXPECT_FALSE(trial_of_network_.runs());
}

TEST_F(NetworkSettingsTest, OnlyWhoReachesItsNewPlaceKeepsIt) {
  carry_out();
  ASSERT_EQ(tell(Operation::kSet, kFixed).result, Result::kOk);
  for (int k = 0; k < 2; ++k) {  // before it is written, and before it is carried out
    const Answer early = tell(Operation::kSave);
    EXPECT_EQ(early.result, Result::kNotSaved);
    EXPECT_NE(early.text.find("not in force yet"), std::string::npos) << early.text;
    EXPECT_EQ(store_.saves(), 0);
    EXPECT_FALSE(networked_.unsaved());
    pass(NetworkTrial::kAnswerTime);
  }
  carry_out();
  pass(100ms);
  EXPECT_EQ(tell(Operation::kSave).result, Result::kOk);
  EXPECT_EQ(saved_address(), "192.168.7.2/24");
  pass(10min);
  EXPECT_EQ(address(), "192.168.7.2/24");
}

TEST_F(NetworkSettingsTest, WhoMayNotChangeItDoesNotKeepIt) {
  ASSERT_EQ(tell(Operation::kSet, kFixed).result, Result::kOk);
  pass(NetworkTrial::kAnswerTime);
  carry_out();
  pass(100ms);
  access_ = firmware::Access::kTune;
  EXPECT_EQ(tell(Operation::kSet, R"({"network": {"dhcp": false}})").text,
            "network.dhcp: takes a key with role admin");
  ASSERT_EQ(tell(Operation::kSet, R"({"depth": {"guided": true}})").result, Result::kOk);
  EXPECT_EQ(tell(Operation::kSave).result, Result::kOk);
  EXPECT_EQ(saved_address(), "");
  pass(NetworkTrial::kConfirmTime);
  EXPECT_EQ(address(), "");
  EXPECT_TRUE(networked_.active().depth.guided);
}

TEST_F(NetworkSettingsTest, TheCableReachesItAtAnyAddress) {
  over_line_ = true;
  ASSERT_EQ(tell(Operation::kSet, kFixed).result, Result::kOk);
  EXPECT_EQ(tell(Operation::kSave).result, Result::kOk);
  EXPECT_EQ(saved_address(), "192.168.7.2/24");
  pass(10min);
  EXPECT_EQ(address(), "192.168.7.2/24");
}

TEST_F(NetworkSettingsTest, ACommitIsOnTrialToo) {
  ASSERT_EQ(tell(Operation::kStage, kFixed).result, Result::kOk);
  EXPECT_EQ(tell(Operation::kCommit).result, Result::kNotSaved);
  EXPECT_EQ(address(), "192.168.7.2/24");
  EXPECT_EQ(store_.saves(), 0);
  pass(NetworkTrial::kConfirmTime + 1s);
  EXPECT_EQ(address(), "");
}

TEST_F(NetworkSettingsTest, WhatWasKeptLastComesBackAfterSeveralChanges) {
  ASSERT_EQ(tell(Operation::kSet, kFixed).result, Result::kOk);
  pass(30s);
  ASSERT_EQ(tell(Operation::kSet, R"({"network": {"address": "192.168.7.3/24"}})").result,
            Result::kOk);
  pass(NetworkTrial::kConfirmTime);
  EXPECT_EQ(address(), "192.168.7.3/24");  // the minute is that of the last one
  pass(1s);
  EXPECT_EQ(address(), "");
  ASSERT_EQ(tell(Operation::kSet, kFixed).result, Result::kOk);
  ASSERT_EQ(tell(Operation::kSet, R"({"network": {"address": ""}})").result, Result::kOk);
  EXPECT_FALSE(trial_of_network_.runs());
}

TEST_F(NetworkSettingsTest, WhereTheLoopIsBusyItIsTakenBackLater) {
  ASSERT_EQ(tell(Operation::kSet, kFixed).result, Result::kOk);
  board_.busy = true;
  pass(NetworkTrial::kConfirmTime + 2s);
  EXPECT_EQ(address(), "192.168.7.2/24");
  board_.busy = false;
  pass(100ms);
  EXPECT_EQ(address(), "");
}

TEST_F(NetworkSettingsTest, WhatLeavesItWithoutAnAddressIsRefused) {
  const auto refused = [this](const char* json) {
    const Answer answer = tell(Operation::kSet, json);
    EXPECT_EQ(answer.result, Result::kInvalid);
    EXPECT_EQ(networked_.active().network, NetworkSettings{});
    return answer.text;
  };
  EXPECT_TRUE(refused(R"({"network": {"dhcp": false, "link_local": false}})")
                  .starts_with("network: leaves the sensor without an address"));
  EXPECT_TRUE(refused(R"({"network": {"gateway": "192.168.7.1"}})")
                  .starts_with("network.gateway: takes a network.address"));
  for (const char* const gateway : {"192.168.8.1", "192.168.7.2", "192.168.7.255", "0.0.0.0"}) {
    const std::string json =
        std::string(R"({"network": {"address": "192.168.7.2/24", "gateway": ")") + gateway + "\"}}";
    EXPECT_TRUE(refused(json.c_str()).starts_with("network.gateway: takes another address"));
  }
}

TEST_F(NetworkSettingsTest, AResetLeavesTheNetworkAlone) {
  over_line_ = true;
  ASSERT_EQ(tell(Operation::kSet, kFixed).result, Result::kOk);
  ASSERT_EQ(tell(Operation::kSave).result, Result::kOk);
  EXPECT_EQ(tell(Operation::kReset).result, Result::kOk);
  EXPECT_EQ(address(), "192.168.7.2/24");
}

// Who fixed the address would not reach the sensor any more.
TEST_F(NetworkSettingsTest, SettingsThatAreDroppedLeaveItsPlace) {
  over_line_ = true;
  ASSERT_EQ(tell(Operation::kSet, kFixed).result, Result::kOk);
  ASSERT_EQ(tell(Operation::kSave).result, Result::kOk);
  store_.bytes() = {std::byte{'?'}};
  std::array<char, kWhyBytes> space;
  PagedWriter line(space);
  const StartSettings start = load_settings({store_, good_, trial_, &fixed_}, "x", nullptr, line);
  EXPECT_NE(start.dropped, Dropped::kNot);
  EXPECT_FALSE(start.strictest);
  EXPECT_EQ(start.settings.network.address.view(), "192.168.7.2/24");
}

}  // namespace
}  // namespace stof::settings
