#include "tests/firmware/upload/upload_server_fixture.h"

namespace stof::upload {
namespace {

TEST_F(UploadServerTest, ChunksInTheirOrderThenACommitPutItInForce) {
  const Answer begun = begin(file_);
  EXPECT_EQ(begun.result, SettingsResult::kOk);
  EXPECT_EQ(begun.fields.wanted, 0);
  EXPECT_EQ(begun.fields.chunk, UploadServer::kChunkBytes);
  send_rest(file_);
  EXPECT_TRUE(shelf_holds(file_));
  EXPECT_EQ(shelf_.commits, 0);
  const Answer committed = commit(file_);
  EXPECT_EQ(committed.result, SettingsResult::kOk);
  EXPECT_EQ(committed.fields.wanted, file_.size());
  EXPECT_EQ(committed.fields.fingerprint, file_.size());
  EXPECT_EQ(committed.fields.former, 7);
  EXPECT_EQ(shelf_.commits, 1);
}

TEST_F(UploadServerTest, LeavesAllOtherOperationsToWhoServesSettings) {
  std::size_t bytes = 1;
  const auto answer = server_.serve({.operation = SettingsOperation::kGet}, {}, {}, {}, bytes);
  EXPECT_EQ(answer.revision, 77);
  EXPECT_EQ(others_.served, 1);
}

TEST_F(UploadServerTest, TakesAnAdmin) {
  for (const Access access : {Access::kRead, Access::kHarmless, Access::kTune}) {
    access_ = access;
    for (const UploadStep step :
         {UploadStep::kBegin, UploadStep::kChunk, UploadStep::kCommit, UploadStep::kRevert}) {
      EXPECT_EQ(ask(request_for(file_, step), file_).result, SettingsResult::kDenied);
    }
  }
  EXPECT_EQ(shelf_.begins + shelf_.commits + shelf_.reverts, 0);
}

TEST_F(UploadServerTest, WhatIsNoRequestIsRefused) {
  Bytes text(wire::kUploadRequestBytes);
  wire::encode_upload_request(request_for(file_, UploadStep::kBegin),
                              std::span(text).first<wire::kUploadRequestBytes>());
  for (std::size_t bytes = 0; bytes < text.size(); ++bytes) {
    EXPECT_EQ(ask_bytes(std::span(text).first(bytes)).result, SettingsResult::kInvalid);
  }
  text[0] = std::byte{9};
  EXPECT_EQ(ask_bytes(text).result, SettingsResult::kInvalid);
  EXPECT_EQ(shelf_.begins, 0);
}

TEST_F(UploadServerTest, AnotherKindIsRefused) {
  wire::UploadRequest request = request_for(file_, UploadStep::kBegin);
  for (const int kind : {0, 2, 255}) {
    request.kind = static_cast<std::uint8_t>(kind);
    EXPECT_EQ(ask(request).result, SettingsResult::kUnsupported);
  }
  EXPECT_EQ(shelf_.begins, 0);
}

TEST_F(UploadServerTest, NothingAndTooMuchAreRefused) {
  EXPECT_EQ(begin({}).result, SettingsResult::kInvalid);
  EXPECT_EQ(begin(Bytes(shelf_.held.size() + 1)).text, "too long");
  EXPECT_EQ(begin(Bytes(shelf_.held.size())).result, SettingsResult::kOk);
}

// Each of a chunk's bytes is written once, wherever else chunks are said to begin.
TEST_F(UploadServerTest, ChunksThatAreNotTheOneWantedChangeNothing) {
  begin(file_);
  EXPECT_EQ(chunk(file_, 960, 960).fields.wanted, 0);  // the second before the first
  EXPECT_EQ(chunk(file_, 0, 960).fields.wanted, 960);
  EXPECT_EQ(chunk(file_, 0, 960).fields.wanted, 960);    // twice
  EXPECT_EQ(chunk(file_, 500, 960).fields.wanted, 960);  // overlapping
  EXPECT_EQ(chunk(file_, 961, 960).fields.wanted, 960);  // a gap
  EXPECT_EQ(chunk(file_, 960, 0).fields.wanted, 960);    // nothing
  EXPECT_EQ(ask(request_for(file_, UploadStep::kChunk, 0xFFFF'FFFF), file_).fields.wanted, 960);
  EXPECT_EQ(shelf_.count, 960);
  send_rest(file_);
  EXPECT_EQ(chunk(file_, 2400, 100).fields.wanted, file_.size());  // the last one again
  EXPECT_TRUE(shelf_holds(file_));
  EXPECT_EQ(commit(file_).result, SettingsResult::kOk);
}

TEST_F(UploadServerTest, RandomChunksInAnyOrderLeaveTheFileOrAnswerWhatIsWanted) {
  for (std::uint64_t seed = 1; seed <= 50; ++seed) {
    test::Random random(seed);
    begin(file_);
    std::uint32_t wanted = 0;
    for (int i = 0; i < 400; ++i) {
      const std::size_t at = i % 3 == 0 ? wanted : random.next() % file_.size();
      const std::size_t most = std::min(file_.size() - at, UploadServer::kChunkBytes);
      const std::size_t bytes = random.next() % (most + 1);
      const Answer answer = chunk(file_, at, bytes);
      ASSERT_EQ(answer.result, SettingsResult::kOk) << "seed " << seed;
      ASSERT_EQ(answer.fields.wanted, at == wanted ? wanted + bytes : wanted) << "seed " << seed;
      wanted = answer.fields.wanted;
    }
    send_rest(file_);
    ASSERT_TRUE(shelf_holds(file_)) << "seed " << seed;
    ASSERT_EQ(commit(file_).result, SettingsResult::kOk) << "seed " << seed;
  }
}

TEST_F(UploadServerTest, AChunkBehindTheEndIsRefused) {
  begin(file_);
  Bytes longer = file_;
  longer.resize(file_.size() + 1);
  send_rest(Bytes(file_));
  Bytes other = file_;
  other[0] ^= std::byte{1};
  begin(other);
  EXPECT_EQ(ask(request_for(other, UploadStep::kChunk), longer).result, SettingsResult::kInvalid);
  EXPECT_EQ(shelf_.count, 0);
}

TEST_F(UploadServerTest, AClientThatStartsAnewGoesOnWhereItStopped) {
  begin(file_);
  chunk(file_, 0, 960);
  now_ += 20s;
  EXPECT_EQ(begin(file_).fields.wanted, 960);
  EXPECT_EQ(shelf_.begins, 1);
  send_rest(file_);
  EXPECT_EQ(commit(file_).result, SettingsResult::kOk);
  EXPECT_TRUE(shelf_holds(file_));
}

TEST_F(UploadServerTest, AnotherFileOfTheSameKeyBeginsAnew) {
  begin(file_);
  chunk(file_, 0, 960);
  Bytes other = file_;
  other[0] ^= std::byte{1};
  EXPECT_EQ(begin(other).fields.wanted, 0);
  EXPECT_EQ(chunk(file_, 960, 960).fields.wanted, 0);  // and so does the first one then
  send_rest(other);
  EXPECT_EQ(commit(other).result, SettingsResult::kOk);
  EXPECT_TRUE(shelf_holds(other));
}

// A sensor that has started anew knows nothing of it.
TEST_F(UploadServerTest, AChunkOrACommitOfWhatIsNotUnderWayBeginsIt) {
  EXPECT_EQ(chunk(file_, 960, 960).fields.wanted, 0);
  EXPECT_EQ(shelf_.begins, 1);
  server_.~UploadServer();
  new (&server_) UploadServer(others_, shelf_);
  const Answer answer = commit(file_);
  EXPECT_EQ(answer.result, SettingsResult::kOk);
  EXPECT_EQ(answer.fields.wanted, 0);  // below the total: nothing was committed
  EXPECT_EQ(shelf_.commits, 0);
}

TEST_F(UploadServerTest, ACommitBeforeTheEndCommitsNothing) {
  begin(file_);
  chunk(file_, 0, 960);
  EXPECT_EQ(commit(file_).fields.wanted, 960);
  EXPECT_EQ(shelf_.commits, 0);
}

TEST_F(UploadServerTest, AnotherHashIsRefusedAndTheNextUploadBeginsAnew) {
  Bytes damaged = file_;
  damaged[1700] ^= std::byte{0x20};
  begin(file_);
  for (std::uint32_t at = 0; at < file_.size();) {
    const std::size_t bytes = std::min(UploadServer::kChunkBytes, file_.size() - at);
    at = ask(request_for(file_, UploadStep::kChunk, at), std::span(damaged).subspan(at, bytes))
             .fields.wanted;
  }
  const Answer refused = commit(file_);
  EXPECT_EQ(refused.result, SettingsResult::kInvalid);
  EXPECT_NE(refused.text.find("hash"), std::string::npos);
  EXPECT_EQ(commit(file_).text, refused.text);  // to whoever did not hear it
  EXPECT_EQ(shelf_.commits, 0);
  EXPECT_EQ(begin(file_).fields.wanted, 0);
  send_rest(file_);
  EXPECT_EQ(commit(file_).result, SettingsResult::kOk);
}

TEST_F(UploadServerTest, ACommitWhoseAnswerWasLostIsAnsweredAgainAndDoneOnce) {
  send_rest(file_);
  EXPECT_EQ(commit(file_).result, SettingsResult::kOk);
  EXPECT_EQ(commit(file_).result, SettingsResult::kOk);
  EXPECT_EQ(shelf_.commits, 1);
  EXPECT_EQ(begin(file_).fields.wanted, 0);  // the same once more, because somebody wants it
  send_rest(file_);
  EXPECT_EQ(commit(file_).result, SettingsResult::kOk);
  EXPECT_EQ(shelf_.commits, 2);
}

TEST_F(UploadServerTest, ARefusalOfTheTargetIsToldAgain) {
  shelf_.answer = SettingsResult::kInvalid;
  shelf_.said = "made for other cameras";
  send_rest(file_);
  EXPECT_EQ(commit(file_).text, "made for other cameras");
  EXPECT_EQ(commit(file_).text, "made for other cameras");
  EXPECT_EQ(shelf_.commits, 1);
}

TEST_F(UploadServerTest, ABusyTargetIsAskedAgain) {
  shelf_.answer = SettingsResult::kBusy;
  shelf_.said = "not now";
  send_rest(file_);
  EXPECT_EQ(commit(file_).result, SettingsResult::kBusy);
  shelf_.answer = SettingsResult::kOk;
  EXPECT_EQ(commit(file_).result, SettingsResult::kOk);
  EXPECT_EQ(shelf_.commits, 2);
}

TEST_F(UploadServerTest, AnotherKeyWaitsUntilTheFirstHasBeenSilentForHalfAMinute) {
  begin(file_);
  chunk(file_, 0, 960);
  key_ = 6;
  for (const UploadStep step :
       {UploadStep::kBegin, UploadStep::kChunk, UploadStep::kCommit, UploadStep::kRevert}) {
    EXPECT_EQ(ask(request_for(file_, step)).result, SettingsResult::kBusy);
  }
  now_ += UploadServer::kPatience;
  EXPECT_EQ(begin(file_).result, SettingsResult::kBusy);  // that asking does not keep it alive
  now_ += 1ns;
  EXPECT_EQ(begin(file_).fields.wanted, 0);  // nothing of another's is taken up
  key_ = 5;
  EXPECT_EQ(chunk(file_, 960, 960).result, SettingsResult::kBusy);
  EXPECT_EQ(shelf_.reverts, 0);
}

TEST_F(UploadServerTest, AKeyThatWasEndedHoldsUpNobody) {
  wire::KeyTable keys;
  ASSERT_EQ(keys.add({.id = 5, .role = wire::Role::kAdmin}), Status::kOk);
  begin(file_);
  chunk(file_, 0, 960);
  server_.drop_ended_keys(keys);
  EXPECT_EQ(begin(file_).fields.wanted, 960);
  keys.clear();
  server_.drop_ended_keys(keys);
  key_ = 6;
  EXPECT_EQ(begin(file_).result, SettingsResult::kOk);
  EXPECT_EQ(begin(file_).fields.wanted, 0);
}

TEST_F(UploadServerTest, AnAbandonedUploadGoesOnUntilAnotherOneIsBegun) {
  begin(file_);
  chunk(file_, 0, 960);
  now_ += 24h;
  EXPECT_EQ(begin(file_).fields.wanted, 960);
  send_rest(file_);
  now_ += 24h;
  EXPECT_EQ(begin(file_).fields.wanted, file_.size());  // all had come, and nobody committed it
  EXPECT_EQ(shelf_.begins, 1);
}

TEST_F(UploadServerTest, AnotherUploadTakesThePlaceOfAnAbandonedOne) {
  begin(file_);
  chunk(file_, 0, 960);
  now_ += UploadServer::kPatience + 1ns;
  key_ = 6;
  EXPECT_EQ(begin(file_).fields.wanted, 0);
  now_ += UploadServer::kPatience + 1ns;
  key_ = 5;
  EXPECT_EQ(begin(file_).fields.wanted, 0);
  EXPECT_EQ(shelf_.begins, 3);
}

TEST_F(UploadServerTest, HowOneEndedIsForgottenAfterHalfAMinute) {
  begin(file_);
  send_rest(file_);
  EXPECT_EQ(commit(file_).result, SettingsResult::kOk);
  EXPECT_EQ(commit(file_).result, SettingsResult::kOk);  // an answer that was lost
  EXPECT_EQ(shelf_.commits, 1);
  now_ += UploadServer::kPatience + 1ns;
  EXPECT_EQ(commit(file_).fields.wanted, 0);  // begins it
  EXPECT_EQ(shelf_.begins, 2);
}

TEST_F(UploadServerTest, ATargetThatTakesNoMoreEndsIt) {
  begin(file_);
  shelf_.full = true;
  EXPECT_EQ(chunk(file_, 0, 960).text, "full");
  EXPECT_EQ(chunk(file_, 0, 960).fields.wanted, 0);
  EXPECT_EQ(commit(file_).text, "full");
  EXPECT_EQ(shelf_.commits, 0);
}

TEST_F(UploadServerTest, ATargetThatIsBusyGetsTheSameChunkAgain) {
  begin(file_);
  shelf_.busy = 2;
  EXPECT_EQ(chunk(file_, 0, 960).result, SettingsResult::kBusy);
  EXPECT_EQ(begin(file_).fields.wanted, 0);
  EXPECT_EQ(chunk(file_, 0, 960).result, SettingsResult::kBusy);
  send_rest(file_);
  EXPECT_EQ(commit(file_).result, SettingsResult::kOk);
  EXPECT_TRUE(shelf_holds(file_));
  EXPECT_EQ(shelf_.begins, 1);
}

TEST_F(UploadServerTest, AskingChangesNothing) {
  begin(file_);
  chunk(file_, 0, 960);
  shelf_.in_force = 9;
  now_ += UploadServer::kPatience;
  key_ = 6;  // whoever is an admin may
  const Answer answer = ask(request_for(Bytes{}, UploadStep::kAsk));
  EXPECT_EQ(answer.result, SettingsResult::kOk);
  EXPECT_EQ(answer.fields.fingerprint, 9);
  key_ = 5;
  EXPECT_EQ(begin(file_).fields.wanted, 960);
  access_ = Access::kTune;
  EXPECT_EQ(ask(request_for(Bytes{}, UploadStep::kAsk)).result, SettingsResult::kDenied);
}

TEST_F(UploadServerTest, AnUpdateHasATargetOfItsOwn) {
  Shelf updates;
  updates.in_force = 3;
  server_.~UploadServer();
  new (&server_) UploadServer(others_, shelf_, &updates);
  wire::UploadRequest request = request_for(file_, UploadStep::kBegin);
  request.kind = static_cast<std::uint8_t>(wire::UploadKind::kUpdate);
  EXPECT_EQ(ask(request).fields.fingerprint, 3);
  EXPECT_EQ(updates.begins, 1);
  EXPECT_EQ(shelf_.begins, 0);
}

TEST_F(UploadServerTest, ARevertGoesBackAndEndsWhatWasUnderWay) {
  begin(file_);
  chunk(file_, 0, 960);
  shelf_.in_force = 9;
  const Answer answer = ask(request_for(Bytes{}, UploadStep::kRevert));
  EXPECT_EQ(answer.result, SettingsResult::kOk);
  EXPECT_EQ(answer.fields.fingerprint, 7);
  EXPECT_EQ(answer.fields.former, 9);
  EXPECT_EQ(chunk(file_, 960, 960).fields.wanted, 0);
}

}  // namespace
}  // namespace stof::upload
