#include "tests/firmware/upload/upload_server_fixture.h"

namespace stof::upload {
namespace {

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

}  // namespace
}  // namespace stof::upload
