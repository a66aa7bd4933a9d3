#pragma once

#include <algorithm>
#include <array>
#include <chrono>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "firmware/settings/text/as_text.h"
#include "firmware/upload/upload_server.h"
#include "tests/support/heap_guard.h"
#include "tests/support/random.h"

namespace stof::upload {

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
    if (busy > 0) {
      --busy;
      why << "not now";
      return SettingsResult::kBusy;
    }
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
  int busy = 0;  // writes
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

}  // namespace stof::upload
