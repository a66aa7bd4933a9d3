#include "firmware/upload/upload_server.h"

#include <algorithm>
#include <array>
#include <chrono>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "firmware/settings/text/as_text.h"
#include "tests/support/heap_guard.h"
#include "tests/support/random.h"

namespace stof::upload {
namespace {

using namespace std::chrono_literals;
using firmware::Access;
using wire::SettingsOperation;
using wire::SettingsResult;
using wire::UploadStep;

using Bytes = std::vector<std::byte>;

// Keeps what comes, and refuses what it is told to.
class Shelf final : public Target {
 public:
  SettingsResult begin(std::uint32_t total, settings::PagedWriter& why) noexcept override {
    ++begins;
    count = 0;
    if (total > held.size()) {
      why << "too long";
      return SettingsResult::kInvalid;
    }
    return SettingsResult::kOk;
  }
  SettingsResult write(std::span<const std::byte> bytes,
                       settings::PagedWriter& why) noexcept override {
    if (full) {
      why << "full";
      return SettingsResult::kNotSaved;
    }
    std::ranges::copy(bytes, held.begin() + static_cast<std::ptrdiff_t>(count));
    count += bytes.size();
    return SettingsResult::kOk;
  }
  SettingsResult commit(const firmware::Requester& /*by*/,
                        settings::PagedWriter& why) noexcept override {
    ++commits;
    why << said;
    if (answer == SettingsResult::kOk) {
      former = in_force;
      in_force = static_cast<std::uint32_t>(count);
    }
    return answer;
  }
  SettingsResult revert(const firmware::Requester& /*by*/,
                        settings::PagedWriter& /*why*/) noexcept override {
    ++reverts;
    former = in_force;
    in_force = 7;
    return SettingsResult::kOk;
  }
  Versions versions() const noexcept override { return {.in_force = in_force, .former = former}; }
  std::span<const std::byte> file_in_force() const noexcept override {
    return std::span(held).first(count);
  }

  std::array<std::byte, 5000> held{};
  std::size_t count = 0;
  int begins = 0;
  int commits = 0;
  int reverts = 0;
  bool full = false;
  SettingsResult answer = SettingsResult::kOk;
  const char* said = "";
  std::uint32_t in_force = 7;
  std::uint32_t former = 0;
};

class Others final : public firmware::SettingsService {
 public:
  wire::SettingsAnswer serve(const wire::SettingsRequest& /*request*/,
                             std::span<const std::byte> /*text*/, const firmware::Requester& /*by*/,
                             std::span<std::byte> /*answer*/,
                             std::size_t& answer_bytes) noexcept override {
    ++served;
    answer_bytes = 0;
    return {.revision = 77};
  }
  int served = 0;
};

struct Answer {
  SettingsResult result = SettingsResult::kOk;
  std::string text;
  wire::UploadAnswer fields;
};

class UploadServerTest : public testing::Test {
 protected:
  void SetUp() override {
    ASSERT_TRUE(wire::start_crypto());
    test::Random random(1);
    for (std::byte& byte : file_) {
      byte = static_cast<std::byte>(random.next());
    }
  }

  static wire::UploadRequest request_for(const Bytes& file, UploadStep step,
                                         std::uint32_t offset = 0) {
    wire::UploadRequest request{.step = step,
                                .kind = static_cast<std::uint8_t>(wire::UploadKind::kCalibration),
                                .total = static_cast<std::uint32_t>(file.size()),
                                .offset = offset};
    const wire::Digest hash = wire::digest_of({}, {file});
    std::ranges::transform(hash, request.hash.begin(),
                           [](std::byte byte) { return std::to_integer<std::uint8_t>(byte); });
    return request;
  }

  Answer ask(const wire::UploadRequest& request, std::span<const std::byte> chunk = {}) {
    Bytes text(wire::kUploadRequestBytes);
    wire::encode_upload_request(request, std::span(text).first<wire::kUploadRequestBytes>());
    text.insert(text.end(), chunk.begin(), chunk.end());
    return ask_bytes(text);
  }
  Answer ask_bytes(std::span<const std::byte> text) {
    std::array<std::byte, 1024> space{};
    std::size_t bytes = 0;
    test::heap_forbidden = true;
    const wire::SettingsAnswer answer = server_.serve(
        {.operation = SettingsOperation::kUpload}, text,
        {.peer = hal::Peer{}, .now = now_, .access = access_, .key_id = key_}, space, bytes);
    test::heap_forbidden = false;
    Answer out{.result = answer.result, .text = {}, .fields = {}};
    const std::span<const std::byte> said = std::span(space).first(bytes);
    if (answer.result == SettingsResult::kOk) {
      const auto read = wire::decode_upload_answer(said);
      EXPECT_TRUE(read);
      out.fields = read.value_or(wire::UploadAnswer{});
    } else {
      out.text = settings::as_text(said);
      EXPECT_FALSE(out.text.empty());
      EXPECT_EQ(out.text.find('\n'), std::string::npos);
    }
    return out;
  }

  Answer begin(const Bytes& file) { return ask(request_for(file, UploadStep::kBegin)); }
  Answer chunk(const Bytes& file, std::size_t offset, std::size_t bytes) {
    return ask(request_for(file, UploadStep::kChunk, static_cast<std::uint32_t>(offset)),
               std::span(file).subspan(offset, bytes));
  }
  Answer commit(const Bytes& file) { return ask(request_for(file, UploadStep::kCommit)); }
  // What is wanted, until all is there.
  void send_rest(const Bytes& file) {
    for (std::uint32_t at = begin_or_wanted(file); at < file.size();) {
      const Answer answer = chunk(file, at, std::min(UploadServer::kChunkBytes, file.size() - at));
      ASSERT_EQ(answer.result, SettingsResult::kOk) << answer.text;
      ASSERT_GT(answer.fields.wanted, at);
      at = answer.fields.wanted;
    }
  }
  std::uint32_t begin_or_wanted(const Bytes& file) { return begin(file).fields.wanted; }
  bool shelf_holds(const Bytes& file) const {
    return shelf_.count == file.size() && std::equal(file.begin(), file.end(), shelf_.held.begin());
  }

  Bytes file_ = Bytes(2500);
  Shelf shelf_;
  Others others_;
  UploadServer server_{others_, shelf_};
  hal::Time now_{1s};
  Access access_ = Access::kAdmin;
  std::uint32_t key_ = 5;
};

TEST_F(UploadServerTest, GivesWhatIsInForceInPartsToAnybody) {
  send_rest(file_);
  access_ = Access::kRead;
  Bytes got;
  for (int parts = 0; parts < 10; ++parts) {
    std::array<std::byte, wire::kDownloadRequestBytes> request{};
    wire::encode_download_request({.kind = 1, .offset = static_cast<std::uint32_t>(got.size())},
                                  request);
    std::array<std::byte, 1024> space{};
    std::size_t bytes = 0;
    const auto answer =
        server_.serve({.operation = SettingsOperation::kDownload}, request,
                      {.peer = hal::Peer{}, .now = now_, .access = access_}, space, bytes);
    ASSERT_EQ(answer.result, SettingsResult::kOk);
    const auto head = wire::decode_download_answer(std::span(space).first(bytes));
    ASSERT_TRUE(head);
    EXPECT_EQ(head->total, file_.size());
    EXPECT_EQ(head->offset, got.size());
    const std::span<const std::byte> part =
        std::span(space).first(bytes).subspan(wire::kDownloadAnswerBytes);
    if (part.empty()) {
      break;
    }
    got.insert(got.end(), part.begin(), part.end());
  }
  EXPECT_EQ(got, file_);
}

TEST_F(UploadServerTest, RefusesDownloadsOfOtherKindsAndCutRequests) {
  std::array<std::byte, wire::kDownloadRequestBytes> request{};
  wire::encode_download_request({.kind = 9}, request);
  std::array<std::byte, 1024> space{};
  std::size_t bytes = 0;
  const auto serve = [&](std::span<const std::byte> text) {
    return server_
        .serve({.operation = SettingsOperation::kDownload}, text,
               {.peer = hal::Peer{}, .now = now_}, space, bytes)
        .result;
  };
  EXPECT_EQ(serve(request), SettingsResult::kUnsupported);
  EXPECT_GT(bytes, 0);
  EXPECT_EQ(serve(std::span(request).first(7)), SettingsResult::kInvalid);
  request[0] = std::byte{1};
  EXPECT_EQ(serve(request), SettingsResult::kNotSaved);  // there is none yet
}

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

TEST_F(UploadServerTest, AnAbandonedUploadExpires) {
  begin(file_);
  chunk(file_, 0, 960);
  now_ += UploadServer::kPatience + 1ns;
  EXPECT_EQ(begin(file_).fields.wanted, 0);
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
