#include <utility>

#include <gtest/gtest.h>

#include "firmware/settings/settings_server.h"
#include "tests/firmware/settings/settings_server_fixture.h"

// What is staged, by whom, and what a commit makes of it.
namespace stof::settings {
namespace {

TEST_F(SettingsServerTest, StagedFieldsBecomeActiveTogetherAndAreSaved) {
  EXPECT_EQ(ask(Operation::kStage, R"({"name": "a", "period_ms": 50})").result, Result::kOk);
  EXPECT_EQ(ask(Operation::kStage, R"({"name": "b"})").result, Result::kOk);
  EXPECT_EQ(ask(Operation::kStage, R"({"name": "c", "x": 1})").result, Result::kInvalid);
  EXPECT_EQ(server_.active(), Settings{});
  EXPECT_EQ(settings_of(Document::kStaged).name.view(), "b");
  // What is set meanwhile and not staged stays.
  EXPECT_EQ(ask(Operation::kSet, R"({"depth": {"temporal": true}})").result, Result::kOk);
  EXPECT_EQ(ask(Operation::kCommit).fields.revision, 3U);
  EXPECT_EQ(server_.active().name.view(), "b");
  EXPECT_EQ(server_.active().period_ms, 50);
  EXPECT_TRUE(server_.active().depth.temporal);
  EXPECT_EQ(settings_of(Document::kSaved), server_.active());
  EXPECT_EQ(board_.applications, 2);
  EXPECT_EQ(store_.saves(), 1);
  // A repeated commit finds nothing staged, and does not write again.
  EXPECT_EQ(ask(Operation::kCommit).result, Result::kOk);
  EXPECT_EQ(store_.saves(), 1);
}

TEST_F(SettingsServerTest, FieldsThatNeedEachOtherMayBeStagedOneByOne) {
  EXPECT_EQ(ask(Operation::kStage, R"({"depth": {"match": {"prefilter": "off"}}})").result,
            Result::kOk);
  const Answer refused = ask(Operation::kCommit);
  EXPECT_EQ(refused.result, Result::kInvalid);
  EXPECT_EQ(server_.active(), Settings{});
  EXPECT_EQ(store_.saves(), 0);
  EXPECT_EQ(ask(Operation::kStage, R"({"depth": {"match": {"texture": "off"}}})").result,
            Result::kOk);
  EXPECT_EQ(ask(Operation::kCommit).result, Result::kOk);
}

TEST_F(SettingsServerTest, RevertForgetsWhatIsStaged) {
  EXPECT_EQ(ask(Operation::kStage, R"({"name": "a"})").result, Result::kOk);
  EXPECT_EQ(ask(Operation::kRevert).result, Result::kOk);
  EXPECT_EQ(settings_of(Document::kStaged), Settings{});
  EXPECT_EQ(ask(Operation::kCommit).fields.revision, 1U);
}

// Another's commit, an admin's even, brings nothing into force that he could not have set.
TEST_F(SettingsServerTest, NobodyStagesWhatHeMayNotSet) {
  access_ = firmware::Access::kTune;
  for (const char* const json :
       {R"({"serial": {"remote": true}})", R"({"limits": {"streams": "none"}})",
        R"({"depth": {"max_range_mm": 600}})", R"({"name": "x", "udp": {"port": 68}})"}) {
    EXPECT_EQ(ask(Operation::kStage, json).result, Result::kDenied) << json;
  }
  EXPECT_EQ(settings_of(Document::kStaged), Settings{});
  // A whole document that changes only what is his is no refusal, and stages nothing else.
  EXPECT_EQ(ask(Operation::kStage, R"({"name": "a", "limits": {"streams": "keep"}})").result,
            Result::kOk);
  access_ = firmware::Access::kAdmin;
  EXPECT_EQ(ask(Operation::kSet, R"({"limits": {"streams": "fixed"}})").result, Result::kOk);
  EXPECT_EQ(ask(Operation::kCommit).result, Result::kOk);
  EXPECT_EQ(server_.active().name.view(), "a");
  EXPECT_EQ(server_.active().limits.streams, StreamLimit::kFixed);
}

// What a key has staged that was ended since never comes into force by somebody else's commit.
TEST_F(SettingsServerTest, NobodyCommitsWhatAnotherKeyHasStaged) {
  ASSERT_EQ(ask(Operation::kStage, R"({"name": "evil"})").result, Result::kOk);
  const std::uint32_t first = std::exchange(key_id_, 0xDEF);
  const Answer commit = ask(Operation::kCommit);
  EXPECT_EQ(commit.result, Result::kDenied);
  EXPECT_EQ(commit.text, "commit: somebody else has staged settings; revert forgets them");
  EXPECT_EQ(ask(Operation::kStage, R"({"period_ms": 50})").result, Result::kDenied);
  EXPECT_EQ(server_.active(), Settings{});
  EXPECT_EQ(ask(Operation::kRevert).result, Result::kOk);
  EXPECT_EQ(ask(Operation::kStage, R"({"period_ms": 50})").result, Result::kOk);
  key_id_ = first;  // whose settings are gone, and who is told
  const Answer late = ask(Operation::kStage, R"({"name": "late"})");
  EXPECT_EQ(late.result, Result::kDenied);
  EXPECT_EQ(late.text,
            "stage: somebody else has reverted what you had staged: revert, and stage all of it "
            "again");
  key_id_ = 0xDEF;
  EXPECT_EQ(ask(Operation::kCommit).result, Result::kOk);
  EXPECT_EQ(server_.active().name, Settings{}.name);
  EXPECT_EQ(server_.active().period_ms, 50);
}

// A large document is staged in parts: half of it must never be committed as the whole.
TEST_F(SettingsServerTest, WhoseStagedSettingsAreRevertedIsToldAtHisNextRequest) {
  for (const Operation next : {Operation::kStage, Operation::kCommit}) {
    key_id_ = 0xABC;
    ASSERT_EQ(ask(Operation::kRevert).result, Result::kOk);
    ASSERT_EQ(ask(Operation::kStage, R"({"name": "half"})").result, Result::kOk);
    key_id_ = 0xDEF;
    ASSERT_EQ(ask(Operation::kRevert).result, Result::kOk);
    key_id_ = 0xABC;
    const std::uint32_t before = server_.revision();
    EXPECT_EQ(ask(next, R"({"period_ms": 50})").result, Result::kDenied);
    EXPECT_EQ(ask(Operation::kCommit).result, Result::kDenied) << "whoever overhears that";
    EXPECT_EQ(server_.revision(), before);
    EXPECT_EQ(settings_of(Document::kStaged), Settings{});
  }
  // Who reverts himself has begun anew.
  EXPECT_EQ(ask(Operation::kRevert).result, Result::kOk);
  EXPECT_EQ(ask(Operation::kStage, R"({"name": "anew"})").result, Result::kOk);
  EXPECT_EQ(ask(Operation::kCommit).result, Result::kOk);
  EXPECT_EQ(server_.active().name.view(), "anew");
}

TEST_F(SettingsServerTest, WhatWasStagedStaysWithinTheLimitsThatCameSince) {
  access_ = firmware::Access::kTune;
  EXPECT_EQ(ask(Operation::kStage, R"({"depth": {"max_range_mm": 2000}})").result, Result::kOk);
  access_ = firmware::Access::kAdmin;
  EXPECT_EQ(ask(Operation::kSet, R"({"limits": {"least_range_mm": 3000}})").result, Result::kOk);
  EXPECT_EQ(ask(Operation::kCommit).result, Result::kDenied);
  EXPECT_EQ(server_.active().depth.max_range_mm, 10'000);
  // What the admin stages himself is his.
  EXPECT_EQ(ask(Operation::kStage, R"({"depth": {"max_range_mm": 2500}})").result, Result::kOk);
  EXPECT_EQ(ask(Operation::kCommit).result, Result::kOk);
  EXPECT_EQ(server_.active().depth.max_range_mm, 2500);
}

TEST_F(SettingsServerTest, WhatIsRevertedHasNotFallenBack) {
  EXPECT_EQ(ask(Operation::kStage, R"({"depth": {"match": {"method": "dp"}}})").text,
            "depth.match.method: not in this version: as the preset has it");
  EXPECT_FALSE(server_.fell_back());
  EXPECT_EQ(ask(Operation::kRevert).result, Result::kOk);
  EXPECT_EQ(ask(Operation::kCommit).result, Result::kOk);
  EXPECT_FALSE(server_.fell_back());
}

}  // namespace
}  // namespace stof::settings
