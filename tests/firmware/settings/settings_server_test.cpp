#include "firmware/settings/settings_server.h"

#include <algorithm>
#include <array>
#include <cstring>
#include <string>
#include <utility>

#include <gtest/gtest.h>

#include "firmware/settings/depth_settings.h"
#include "firmware/settings/fields/document.h"
#include "firmware/settings/fields/presets.h"
#include "firmware/settings/saved_settings.h"
#include "firmware/settings/text/as_text.h"
#include "hal/emu/devices/store.h"
#include "tests/firmware/settings/settings_server_fixture.h"

namespace stof::settings {
namespace {

TEST_F(SettingsServerTest, GivesDocumentsInPartsOfAnySize) {
  const std::string whole = read(Document::kSchema, 65'535);
  EXPECT_GT(whole.size(), 4096U);
  EXPECT_EQ(read(Document::kSchema, 1024), whole);
  EXPECT_EQ(read(Document::kSchema, 7), whole);
  const Answer beyond = ask(Operation::kGet, "", Document::kActive, 60'000);
  EXPECT_EQ(beyond.result, Result::kOk);
  EXPECT_EQ(beyond.text, "");
  EXPECT_EQ(beyond.fields.total, read(Document::kActive).size());
}

TEST_F(SettingsServerTest, TellsAnAdminTheAddressesThatItsComputerHas) {
  constexpr auto kLoopback = hal::from_ipv4(127, 0, 0, 1);
  constexpr auto kOne = hal::from_ipv4(192, 168, 7, 2);
  constexpr auto kOther = hal::from_ipv4(169, 254, 0, 255);
  std::array<hal::InterfaceAddress, 4> all{};
  all[0].address = kLoopback;
  all[1].address = kOne;
  all[2].address[0] = 0xfe;  // IPv6
  all[3].address = kOther;
  interfaces_.set({});
  EXPECT_EQ(read(Document::kNetwork), R"({"ipv4": []})");
  interfaces_.set(all);
  EXPECT_EQ(read(Document::kNetwork), R"({"ipv4": ["192.168.7.2", "169.254.0.255"]})");
  EXPECT_EQ(read(Document::kNetwork, 5), read(Document::kNetwork));
  for (const firmware::Access access : {firmware::Access::kHarmless, firmware::Access::kTune}) {
    access_ = access;
    const Answer answer = ask(Operation::kGet, "", Document::kNetwork);
    EXPECT_EQ(answer.result, Result::kDenied);
    EXPECT_TRUE(answer.text.starts_with("network: takes a key with role admin")) << answer.text;
  }
}

TEST_F(SettingsServerTest, SetIsInForceAtOnceAndNotSaved) {
  const Answer answer = ask(Operation::kSet, R"({"depth": {"guided": true}})");
  EXPECT_EQ(answer.result, Result::kOk);
  EXPECT_EQ(answer.fields.revision, 2U);
  EXPECT_EQ(answer.fields.restart, 0);
  EXPECT_TRUE(board_.applied.depth.guided);
  EXPECT_EQ(board_.applied_revision, 2U);
  EXPECT_EQ(settings_of(Document::kActive), board_.applied);
  EXPECT_EQ(settings_of(Document::kStaged), board_.applied);
  EXPECT_EQ(settings_of(Document::kSaved), Settings{});
  EXPECT_EQ(store_.saves(), 0);
}

TEST_F(SettingsServerTest, WhoeverMayNotIsToldAndChangesNothing) {
  access_ = firmware::Access::kTune;
  for (const Operation operation : {Operation::kStage, Operation::kSet}) {
    const Answer port = ask(operation, R"({"udp": {"port": 68}})");
    EXPECT_EQ(port.result, Result::kDenied);
    EXPECT_EQ(port.text, "udp.port: takes a key with role admin");
  }
  access_ = firmware::Access::kAdmin;  // who stages more than others may commit
  ASSERT_EQ(ask(Operation::kStage, R"({"udp": {"port": 68}})").result, Result::kOk);
  access_ = firmware::Access::kTune;
  EXPECT_EQ(ask(Operation::kCommit).result, Result::kDenied);
  ASSERT_EQ(ask(Operation::kRevert).result, Result::kOk);
  access_ = firmware::Access::kHarmless;
  EXPECT_EQ(ask(Operation::kSet, R"({"depth": {"max_range_mm": 9000}})").result, Result::kOk);
  EXPECT_EQ(board_.applied.depth.max_range_mm, 9000);
  for (const Operation operation :
       {Operation::kStage, Operation::kCommit, Operation::kRevert, Operation::kSave}) {
    const Answer answer = ask(operation, "{}");
    EXPECT_EQ(answer.result, Result::kDenied);
    EXPECT_NE(answer.text.find(": takes a key with role tune or admin: pair"), std::string::npos);
  }
  EXPECT_EQ(ask(Operation::kPreset, "near").result, Result::kDenied);
  access_ = firmware::Access::kRead;
  EXPECT_EQ(ask(Operation::kReset).result, Result::kDenied);
  EXPECT_EQ(ask(Operation::kSet, R"({"depth": {"max_range_mm": 8000}})").result, Result::kDenied);
  EXPECT_EQ(board_.applications, 1);
  EXPECT_EQ(store_.saves(), 0);
  EXPECT_EQ(ask(Operation::kGet).result, Result::kOk);
}

TEST_F(SettingsServerTest, ResetAndPresetAreHarmlessWhereNoOtherFieldDiffers) {
  const std::string harmless =
      R"({"depth": {"max_range_mm": 9000}, "streams": {"grey_left": "rvl", "parity": true}})";
  const auto as = [this](firmware::Access access, Operation operation, const std::string& text) {
    access_ = access;
    return ask(operation, text);
  };
  using firmware::Access;
  ASSERT_EQ(as(Access::kHarmless, Operation::kSet, harmless).result, Result::kOk);
  ASSERT_NE(server_.active(), Settings{});
  ASSERT_EQ(as(Access::kHarmless, Operation::kReset, "").result, Result::kOk);
  EXPECT_EQ(server_.active(), Settings{});
  for (const SettingsPreset& preset : presets()) {
    const std::string name(preset.name);
    ASSERT_EQ(as(Access::kAdmin, Operation::kReset, "").result, Result::kOk);
    ASSERT_EQ(as(Access::kAdmin, Operation::kPreset, name).result, Result::kOk);
    const Settings admins = server_.active();
    ASSERT_EQ(as(Access::kHarmless, Operation::kSet, R"({"depth": {"max_range_mm": 9000}})").result,
              Result::kOk);
    ASSERT_EQ(as(Access::kHarmless, Operation::kPreset, name).result, Result::kOk) << name;
    EXPECT_EQ(server_.active() == admins, name != "fast" && name != "quality") << name;
  }
  // Another field that would change: nothing does, and that field is named.
  ASSERT_EQ(as(Access::kAdmin, Operation::kReset, "").result, Result::kOk);
  ASSERT_EQ(as(Access::kAdmin, Operation::kSet, R"({"name": "left"})").result, Result::kOk);
  ASSERT_EQ(as(Access::kHarmless, Operation::kSet, harmless).result, Result::kOk);
  const Settings before = server_.active();
  const Answer reset = as(Access::kHarmless, Operation::kReset, "");
  EXPECT_EQ(reset.result, Result::kDenied);
  EXPECT_TRUE(reset.text.starts_with("name: takes a key with role tune or admin")) << reset.text;
  const Answer near = as(Access::kHarmless, Operation::kPreset, "near");
  EXPECT_EQ(near.result, Result::kDenied);
  EXPECT_TRUE(near.text.starts_with("depth.guided: takes a key")) << near.text;
  EXPECT_EQ(server_.active(), before);
  EXPECT_EQ(store_.saves(), 0);
}

TEST_F(SettingsServerTest, WhatChangesNothingIsNoRevision) {
  EXPECT_EQ(ask(Operation::kSet, "{}").fields.revision, 1U);
  EXPECT_EQ(ask(Operation::kSet, R"({"name": "stof"})").fields.revision, 1U);
  EXPECT_EQ(board_.applications, 0);
}

TEST_F(SettingsServerTest, RefusalsChangeNothing) {
  const Answer field = ask(Operation::kSet, R"({"name": "a", "period_ms": -1})");
  EXPECT_EQ(field.result, Result::kInvalid);
  EXPECT_EQ(field.text, "period_ms: takes 0 to 60000, not -1");
  const Answer limit = ask(Operation::kSet, R"({"depth": {"disparities": 129}})");
  EXPECT_EQ(limit.result, Result::kInvalid);
  EXPECT_EQ(limit.text, "too many disparities");
  const Answer pair = ask(Operation::kSet, R"({"depth": {"match": {"prefilter": "off"}}})");
  EXPECT_EQ(pair.result, Result::kInvalid);
  EXPECT_TRUE(pair.text.starts_with("depth.match: ")) << pair.text;
  EXPECT_EQ(server_.active(), Settings{});
  EXPECT_EQ(server_.revision(), 1U);
  EXPECT_EQ(board_.applications, 0);
}

TEST_F(SettingsServerTest, BusyChangesNothing) {
  board_.busy = true;
  EXPECT_EQ(ask(Operation::kSet, R"({"name": "a"})").result, Result::kBusy);
  EXPECT_EQ(ask(Operation::kStage, R"({"name": "b"})").result, Result::kOk);
  EXPECT_EQ(ask(Operation::kCommit).result, Result::kBusy);
  EXPECT_EQ(server_.active(), Settings{});
  board_.busy = false;
  EXPECT_EQ(ask(Operation::kCommit).result, Result::kOk);
  EXPECT_EQ(server_.active().name.view(), "b");
}

TEST_F(SettingsServerTest, PresetsOfOnePlaceUndoEachOther) {
  for (const SettingsPreset& preset : presets()) {
    EXPECT_EQ(ask(Operation::kReset).result, Result::kOk);
    EXPECT_EQ(ask(Operation::kPreset, std::string(preset.name)).result, Result::kOk);
    EXPECT_EQ(ask(Operation::kPreset, std::string(preset.name)).result, Result::kOk);
  }
  EXPECT_EQ(ask(Operation::kReset).result, Result::kOk);
  EXPECT_EQ(ask(Operation::kPreset, "indoor").result, Result::kOk);
  const Settings indoor = server_.active();
  EXPECT_EQ(ask(Operation::kPreset, "near").result, Result::kOk);
  EXPECT_EQ(server_.active().depth.max_range_mm, 2000);
  EXPECT_EQ(ask(Operation::kPreset, "indoor").result, Result::kOk);
  EXPECT_EQ(server_.active(), indoor);
  const Answer unknown = ask(Operation::kPreset, "Indoor");
  EXPECT_EQ(unknown.result, Result::kInvalid);
  EXPECT_EQ(unknown.text, "preset: takes indoor, outdoor, near, fast or quality");
}

TEST_F(SettingsServerTest, TellsWhatWaitsForARestart) {
  EXPECT_EQ(ask(Operation::kSet, R"({"udp": {"port": 7000}})").fields.restart, 1);
  EXPECT_TRUE(server_.restart_needed());
  EXPECT_EQ(ask(Operation::kSave).fields.restart, 1);
  EXPECT_EQ(settings_of(Document::kSaved).udp_port, 7000);
  EXPECT_EQ(ask(Operation::kReset).fields.restart, 0);
}

TEST_F(SettingsServerTest, TellsWhetherTheSensorRunsWithWhatIsSaved) {
  ASSERT_NE(server_.saved_in_force(), nullptr) << "what the start found";
  EXPECT_EQ(*server_.saved_in_force(), Settings{});
  ask(Operation::kSet, R"({"name": "a"})");
  EXPECT_EQ(server_.saved_in_force(), nullptr);
  ask(Operation::kSave);
  ASSERT_NE(server_.saved_in_force(), nullptr);
  EXPECT_EQ(server_.saved_in_force()->name.view(), "a");
  ask(Operation::kSet, R"({"udp": {"port": 7000}})");
  ask(Operation::kSave);
  EXPECT_EQ(server_.saved_in_force(), nullptr) << "the port waits for the next start";
}

TEST_F(SettingsServerTest, ThreadsWaitForARestart) {
  EXPECT_EQ(ask(Operation::kSet, R"({"compute": {"threads": 3}})").fields.restart, 1);
  EXPECT_EQ(board_.applied.compute.threads, 3);
  EXPECT_EQ(ask(Operation::kSet, R"({"compute": {"threads": 0}})").fields.restart, 0);
  EXPECT_EQ(ask(Operation::kStage, R"({"compute": {"threads": 8}})").result, Result::kOk);
  EXPECT_EQ(ask(Operation::kCommit).fields.restart, 1);
  EXPECT_EQ(settings_of(Document::kSaved).compute.threads, 8);
  const Answer many = ask(Operation::kSet, R"({"compute": {"threads": 9}})");
  EXPECT_EQ(many.result, Result::kInvalid);
  EXPECT_EQ(many.text, "compute.threads: takes 0 to 8, not 9");
  EXPECT_EQ(server_.active().compute.threads, 8);
}

TEST_F(SettingsServerTest, TellsWhatCouldNotBeSaved) {
  store_.break_down(true);
  EXPECT_EQ(ask(Operation::kSet, R"({"name": "a"})").result, Result::kOk);
  EXPECT_FALSE(server_.unsaved());
  const Answer answer = ask(Operation::kSave);
  EXPECT_EQ(answer.result, Result::kNotSaved);
  EXPECT_NE(answer.text, "");
  EXPECT_TRUE(server_.unsaved());
  EXPECT_EQ(server_.active().name.view(), "a");
  EXPECT_EQ(settings_of(Document::kSaved), Settings{});
  store_.break_down(false);
  EXPECT_EQ(ask(Operation::kSave).result, Result::kOk);
  EXPECT_FALSE(server_.unsaved());
  SettingsServer without(Settings{}, Settings{}, {.limits = board_, .sink = board_});
  std::array<std::byte, 256> space{};
  std::size_t bytes = 0;
  const std::string text = R"({"name": "b"})";
  static_cast<void>(without.serve({.operation = Operation::kStage}, std::as_bytes(std::span(text)),
                                  {.peer = {}, .access = firmware::Access::kAdmin}, space, bytes));
  EXPECT_EQ(without
                .serve({.operation = Operation::kCommit}, {},
                       {.peer = {}, .access = firmware::Access::kAdmin}, space, bytes)
                .result,
            Result::kNotSaved);
  EXPECT_EQ(without.active().name.view(), "b");
  EXPECT_FALSE(without.unsaved()) << "nothing was ever promised: the sensor is well";
}

// What a command line adds at each start is not written to the file, unless somebody asks for it.
TEST_F(SettingsServerTest, DoesNotSaveWhatTheCommandLineAloneSet) {
  Settings active;
  active.udp_port = 7000;
  active.depth.max_range_mm = 5000;
  active.name = decltype(active.name)("line");
  SettingsServer server(active, Settings{}, {.limits = board_, .sink = board_, .store = &store_});
  const auto ask_server = [&](Operation operation, const std::string& text = "") {
    std::array<std::byte, 256> space{};
    std::size_t bytes = 0;
    return server
        .serve({.operation = operation}, std::as_bytes(std::span(text)),
               {.peer = peer_, .now = now_, .access = access_, .key_id = key_id_}, space, bytes)
        .result;
  };
  const auto saved = [&] {
    std::array<char, 256> space;
    PagedWriter line(space);
    return load_settings({store_, good_, trial_}, "x.json", &board_, line).settings;
  };
  EXPECT_EQ(ask_server(Operation::kSave), Result::kOk);
  EXPECT_EQ(store_.saves(), 0) << "there is nothing to save";
  EXPECT_EQ(ask_server(Operation::kSet, R"({"depth": {"guided": true, "max_range_mm": 5000}})"),
            Result::kOk);
  EXPECT_EQ(ask_server(Operation::kSave), Result::kOk);
  Settings wanted;
  wanted.depth.guided = true;
  wanted.depth.max_range_mm = 5000;  // the request named it
  EXPECT_EQ(saved(), wanted);
  EXPECT_NE(server.saved_in_force(), nullptr) << "what a command line adds does not count";
  EXPECT_EQ(ask_server(Operation::kStage, R"({"name": "line"})"), Result::kOk);
  EXPECT_EQ(ask_server(Operation::kCommit), Result::kOk);
  wanted.name = active.name;
  EXPECT_EQ(saved(), wanted);
  EXPECT_EQ(ask_server(Operation::kReset), Result::kOk);
  EXPECT_EQ(ask_server(Operation::kSave), Result::kOk);
  EXPECT_EQ(saved(), Settings{});
  EXPECT_EQ(server.active().udp_port, 7000) << "where it listens";
}

// Alone, what the command line completes may be nothing that the sensor can run with.
TEST_F(SettingsServerTest, SavesNothingThatNeedsTheCommandLine) {
  Settings saved;
  saved.depth.disparities = 200;  // too many for this board
  SettingsServer server(Settings{}, saved, {.limits = board_, .sink = board_, .store = &store_});
  std::array<std::byte, 256> space{};
  std::size_t bytes = 0;
  const std::string text = R"({"name": "b"})";
  const firmware::Requester by{.peer = peer_, .now = now_, .access = access_};
  static_cast<void>(server.serve({.operation = Operation::kSet}, std::as_bytes(std::span(text)), by,
                                 space, bytes));
  EXPECT_EQ(server.serve({.operation = Operation::kSave}, {}, by, space, bytes).result,
            Result::kNotSaved);
  EXPECT_EQ(store_.saves(), 0);
}

TEST_F(SettingsServerTest, WarnsWhoeverClosesTheLineThatHeAsksOver) {
  const std::string mavlink = R"({"serial": {"mode": "mavlink"}})";
  ASSERT_EQ(ask(Operation::kSet, R"({"serial": {"mode": "stof"}})").text, "");
  EXPECT_EQ(ask(Operation::kSet, mavlink).text, "") << "over the network it can be set back";
  ASSERT_EQ(ask(Operation::kSet, R"({"serial": {"mode": "stof"}})").text, "");
  peer_ = {};  // a line that leads to strangers
  EXPECT_NE(ask(Operation::kSet, mavlink).text.find("takes no more requests"), std::string::npos);
  Settings over_line;
  over_line.serial.mode = SerialMode::kStof;
  SettingsServer server(over_line, Settings{}, {.limits = board_, .sink = board_});
  std::array<std::byte, 256> space{};
  std::size_t bytes = 0;
  const auto answer =
      server.serve({.operation = Operation::kSet}, std::as_bytes(std::span(mavlink)),
                   {.peer = std::nullopt, .access = firmware::Access::kAdmin}, space, bytes);
  EXPECT_EQ(answer.result, Result::kOk);
  EXPECT_NE(as_text(std::span(space).first(bytes)).find("takes no more requests"),
            std::string_view::npos);
}

// Flash wears out: a stranger who saves a hundred times a second must not end a sensor's life.
TEST_F(SettingsServerTest, SavesTenTimesThenOnceAMinute) {
  int saved = 0;
  const auto save_another = [&](int round) {
    EXPECT_EQ(ask(Operation::kSet, "{\"name\": \"" + std::to_string(round) + "\"}").result,
              Result::kOk);
    const Answer answer = ask(Operation::kSave);
    saved += answer.result == Result::kOk ? 1 : 0;
    return answer;
  };
  for (int round = 0; round < 1060; ++round) {  // 106 a second, ten seconds long
    now_ += std::chrono::microseconds(9434);
    save_another(round);
  }
  EXPECT_EQ(saved, static_cast<int>(SettingsServer::kMostSaves));
  EXPECT_EQ(store_.saves(), saved);
  EXPECT_TRUE(server_.unsaved());
  EXPECT_EQ(save_another(2000).text,
            "active, but not saved: 10 saves at once, then one a minute: save again later");
  now_ += std::chrono::minutes(1);
  EXPECT_EQ(save_another(2001).result, Result::kOk);
  EXPECT_FALSE(server_.unsaved());
  EXPECT_EQ(save_another(2002).result, Result::kNotSaved);
}

TEST_F(SettingsServerTest, TellsWhoChangedThem) {
  EXPECT_EQ(ask(Operation::kGet).result, Result::kOk);
  EXPECT_EQ(ask(Operation::kSet, R"({"name": 1})").result, Result::kInvalid);
  EXPECT_EQ(changes_.size(), 0U) << "nothing changed";
  const hal::Peer other{.address = {1, 2, 4, 8, 0, 0, 0, 0, 0, 0, 0, 0, 5, 6, 7, 8}, .port = 4};
  const std::array by{peer_, other, peer_};
  for (std::size_t i = 0; i < by.size(); ++i) {
    peer_ = by[i];
    EXPECT_EQ(ask(Operation::kSet, R"({"name": "a)" + std::to_string(i) + "\"}").result,
              Result::kOk);
  }
  for (const hal::Peer& expected : by) {
    const auto change = changes_.pop();
    ASSERT_TRUE(change.has_value());
    EXPECT_EQ(change->kind, firmware::EventKind::kSettingsChanged);
    EXPECT_EQ(change->address, expected.address);
    // Nobody's address is that of the serial line.
    EXPECT_EQ(change->value, expected == other ? 0x05060708U : 0xFFFF'FFFFU);
  }
}

TEST_F(SettingsServerTest, SavesOverWhatTheStartCouldNotUse) {
  SettingsServer server({}, {},
                        {.limits = board_, .sink = board_, .store = &store_, .dropped = true});
  EXPECT_TRUE(server.dropped());
  std::array<std::byte, 256> space{};
  std::size_t bytes = 0;
  EXPECT_EQ(server
                .serve({.operation = Operation::kSave}, {},
                       {.peer = {}, .access = firmware::Access::kAdmin}, space, bytes)
                .result,
            Result::kOk);
  EXPECT_EQ(store_.saves(), 1);
  EXPECT_FALSE(server.dropped());
}

TEST_F(SettingsServerTest, AnswersWhatItDoesNotKnow) {
  EXPECT_EQ(ask(Operation{8}).result, Result::kUnsupported);
  EXPECT_EQ(ask(Operation{255}, "x").result, Result::kUnsupported);
  EXPECT_EQ(ask(Operation::kGet, "", Document{6}).result, Result::kUnsupported);
  EXPECT_EQ(ask(Operation::kSet, "").result, Result::kInvalid);
  EXPECT_EQ(ask(Operation::kSet, "{", {}, 0, 0).result, Result::kInvalid);
  // What a text says is told with what it takes.
  const Answer value = ask(Operation::kSet, R"({"streams": {"depth": "foo"}})");
  EXPECT_EQ(value.result, Result::kInvalid);
  EXPECT_EQ(value.text, "streams.depth: takes off, raw, rvl or fit, not \"foo\"");
}

TEST_F(SettingsServerTest, NextStartBeginsWithWhatWasSaved) {
  EXPECT_EQ(ask(Operation::kStage, R"({"name": "a", "depth": {"match": {"lr": 2}}})").result,
            Result::kOk);
  EXPECT_EQ(ask(Operation::kCommit).result, Result::kOk);
  std::array<char, 256> space;
  PagedWriter line(space);
  EXPECT_EQ(load_settings({store_, good_, trial_}, "x.json", &board_, line).settings,
            server_.active());
  EXPECT_EQ(line.text(), "");
}

TEST_F(SettingsServerTest, RequestsThatNameWhatLeftAreTakenAndTold) {
  const Answer answer = ask(Operation::kSet, R"({"depth": {"match": {"pyramid": 2, "lr": 3}}})");
  EXPECT_EQ(answer.result, Result::kOk);
  EXPECT_EQ(answer.text, "depth.match.pyramid: not in this version: as the preset has it");
  EXPECT_EQ(depth_params(server_.active(), 64).match.left_right_tolerance, 3);
  EXPECT_TRUE(server_.fell_back());
  EXPECT_EQ(ask(Operation::kSave).result, Result::kOk);
  EXPECT_FALSE(server_.fell_back());
  EXPECT_EQ(ask(Operation::kSet, R"({"depth": {"match": {"unheard": 1}}})").result,
            Result::kInvalid);
  EXPECT_EQ(ask(Operation::kStage, R"({"depth": {"match": {"block": "30x30"}}})").text, "");
  const Answer commit = ask(Operation::kCommit);
  EXPECT_EQ(commit.result, Result::kOk);
  EXPECT_EQ(commit.text,
            "depth.match.block: sums of such blocks do not fit 16 bits: as the preset has it");
}

TEST(DepthOfSettings, IsThePresetAndWhatChangesIt) {
  Settings settings;
  const dsp::DepthParams fast = depth_params(settings, 64);
  EXPECT_EQ(fast.match.disparities, 64);
  EXPECT_EQ(fast.match.search, dsp::Search::kBlocks);
  EXPECT_EQ(fast.fusion.max_range, 40'000);
  EXPECT_FALSE(fast.guided || fast.temporal);
  std::array<char, kWhyBytes> space;
  PagedWriter why(space);
  ASSERT_TRUE(parse(std::string_view(R"({"depth": {"match": {"lr": "off", "penalties": "1,9"},
      "preset": "quality", "max_range_mm": 16380, "disparities": 96, "guided": true}})"),
                    settings, why))
      << why.text();
  const dsp::DepthParams quality = depth_params(settings, 64);
  EXPECT_EQ(quality.match.search, dsp::Search::kSemiGlobal);
  EXPECT_EQ(quality.match.disparities, 96);
  EXPECT_EQ(quality.match.left_right_tolerance, std::nullopt);
  EXPECT_EQ(quality.match.smoothness->large_step, 9);
  EXPECT_EQ(quality.fusion.max_range, 65'520);
  EXPECT_TRUE(quality.guided);
  EXPECT_NE(std::memcmp(&quality.fusion.trust.sigma_by_ratio, &fast.fusion.trust.sigma_by_ratio,
                        sizeof fast.fusion.trust.sigma_by_ratio),
            0);
}

}  // namespace
}  // namespace stof::settings
