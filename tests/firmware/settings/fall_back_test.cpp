#include <array>
#include <string>
#include <string_view>

#include <gtest/gtest.h>

#include "firmware/settings/settings_server.h"
#include "tests/firmware/settings/settings_server_fixture.h"

namespace stof::settings {
namespace {

// Nobody may make a field fall back that he may not set: that is a condition until the next save.
TEST_F(SettingsServerTest, WhoMayNotSetAFieldMayNotMakeItFallBack) {
  for (const firmware::Access access : {firmware::Access::kRead, firmware::Access::kHarmless}) {
    access_ = access;
    for (const std::string_view named :
         {"pyramid\": 3", "method\": \"x", "penalties\": \"90,200,10", "block\": \"30x30"}) {
      const std::string name(named.substr(0, named.find('"')));
      const std::string end = named.ends_with('3') ? "}}}" : "\"}}}";
      const std::string text = std::string(R"({"depth": {"match": {")").append(named).append(end);
      const Answer answer = ask(Operation::kSet, text);
      EXPECT_EQ(answer.result, Result::kDenied) << text;
      EXPECT_TRUE(answer.text.starts_with("depth.match." + name + ": takes a key with role tune"))
          << answer.text;
      EXPECT_EQ(ask(Operation::kStage, text).result, Result::kDenied) << text;
    }
  }
  // Beside what he may set too: nothing changes.
  EXPECT_EQ(
      ask(Operation::kSet, R"({"depth": {"max_range_mm": 9000, "match": {"band": 3}}})").result,
      Result::kDenied);
  EXPECT_FALSE(server_.fell_back());
  EXPECT_EQ(server_.active(), Settings{});
  EXPECT_EQ(changes_.size(), 0U);
  EXPECT_EQ(ask(Operation::kSet, R"({"depth": {"match": {"pyramid": "preset"}}})").result,
            Result::kOk)
      << "nothing falls back";
  EXPECT_FALSE(server_.fell_back());
}

TEST_F(SettingsServerTest, WhatFallsBackIsToldAsAnyChangeIs) {
  access_ = firmware::Access::kTune;
  const std::string left = R"({"depth": {"match": {"method": "x"}}})";
  const auto expect_told = [&](std::uint32_t revision) {
    EXPECT_EQ(server_.revision(), revision);
    EXPECT_EQ(board_.applied_revision, revision);
    const auto change = changes_.pop();
    ASSERT_TRUE(change.has_value());
    EXPECT_EQ(change->kind, firmware::EventKind::kSettingsChanged);
    EXPECT_EQ(change->address, peer_.address);
    EXPECT_EQ(changes_.size(), 0U);
  };
  EXPECT_EQ(ask(Operation::kSet, left).result, Result::kOk);
  EXPECT_TRUE(server_.fell_back());
  expect_told(2);
  EXPECT_EQ(server_.active(), Settings{});
  EXPECT_EQ(ask(Operation::kSet, R"({"depth": {"match": {"block": "30x30"}}})").result,
            Result::kOk);
  expect_told(3);
  EXPECT_EQ(ask(Operation::kStage, left).result, Result::kOk);
  EXPECT_EQ(changes_.size(), 0U);
  EXPECT_EQ(ask(Operation::kCommit).result, Result::kOk);
  expect_told(4);
  EXPECT_FALSE(server_.fell_back()) << "it is saved";
}

// Without a file the condition lasts until the next change: of those who could have raised it.
TEST_F(SettingsServerTest, WhoMayNotMakeAFieldFallBackMayNotHideThatOneDid) {
  SettingsServer server({}, {}, {.limits = board_, .sink = board_, .fell_back = true});
  const auto set = [&](firmware::Access access, const std::string& text) {
    std::array<std::byte, 256> space{};
    std::size_t bytes = 0;
    return server
        .serve({.operation = Operation::kSet}, std::as_bytes(std::span(text)),
               {.peer = peer_, .now = now_, .access = access}, space, bytes)
        .result;
  };
  EXPECT_EQ(set(firmware::Access::kRead, "{}"), Result::kOk);
  EXPECT_EQ(set(firmware::Access::kHarmless, R"({"depth": {"max_range_mm": 9000}})"), Result::kOk);
  EXPECT_TRUE(server.fell_back());
  EXPECT_EQ(set(firmware::Access::kTune, R"({"depth": {"max_range_mm": 8000}})"), Result::kOk);
  EXPECT_FALSE(server.fell_back());
}

// What the command line alone set is saved once a request names it: of those who may set it.
TEST_F(SettingsServerTest, WhoMayNotSetAFieldDoesNotHaveItSavedByNamingIt) {
  Settings active;
  active.udp_port = 7000;
  Settings saved;
  saved.name = decltype(saved.name)("saved");
  SettingsServer server(active, saved, {.limits = board_, .sink = board_, .store = &store_});
  const auto ask_server = [&](firmware::Access access, Operation operation,
                              const std::string& text = "") {
    std::array<std::byte, 256> space{};
    std::size_t bytes = 0;
    return server
        .serve({.operation = operation}, std::as_bytes(std::span(text)),
               {.peer = peer_, .now = now_, .access = access, .key_id = key_id_}, space, bytes)
        .result;
  };
  EXPECT_EQ(ask_server(firmware::Access::kRead, Operation::kSet,
                       R"({"udp": {"port": 7000}, "name": "stof"})"),
            Result::kOk);
  EXPECT_EQ(ask_server(firmware::Access::kRead, Operation::kReset), Result::kOk);
  EXPECT_EQ(ask_server(firmware::Access::kTune, Operation::kSave), Result::kOk);
  EXPECT_EQ(store_.saves(), 0) << "there is nothing to save";
  EXPECT_EQ(ask_server(firmware::Access::kAdmin, Operation::kSet, R"({"udp": {"port": 7000}})"),
            Result::kOk);
  EXPECT_EQ(ask_server(firmware::Access::kTune, Operation::kSave), Result::kOk);
  EXPECT_EQ(store_.saves(), 1);
}

}  // namespace
}  // namespace stof::settings
