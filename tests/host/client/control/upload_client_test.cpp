#include "host/client/control/upload_client.h"

#include <algorithm>
#include <deque>
#include <functional>
#include <memory>
#include <optional>
#include <vector>

#include <gtest/gtest.h>

#include "firmware/upload/upload_server.h"
#include "firmware/wire/bytes.h"
#include "firmware/wire/crc32c.h"
#include "firmware/wire/crypto/crypto.h"
#include "firmware/wire/messages/settings_answer.h"
#include "firmware/wire/messages/settings_request.h"
#include "host/client/control/download.h"

namespace stof::client {
namespace {

using namespace std::chrono_literals;
using Bytes = std::vector<std::byte>;
using wire::SettingsResult;

class Shelf final : public upload::Target {
 public:
  SettingsResult begin(std::uint32_t /*total*/, settings::PagedWriter& /*why*/) noexcept override {
    held.clear();
    return SettingsResult::kOk;
  }
  SettingsResult write(std::span<const std::byte> bytes,
                       settings::PagedWriter& /*why*/) noexcept override {
    held.insert(held.end(), bytes.begin(), bytes.end());
    return SettingsResult::kOk;
  }
  SettingsResult commit(const firmware::Requester& /*by*/,
                        settings::PagedWriter& why) noexcept override {
    ++commits;
    why << "told\nso";
    return commits <= busy ? SettingsResult::kBusy : answer;
  }
  SettingsResult revert(const firmware::Requester& /*by*/,
                        settings::PagedWriter& /*why*/) noexcept override {
    ++reverts;
    return SettingsResult::kOk;
  }
  upload::Versions versions() const noexcept override {
    return {.in_force = fingerprint, .former = 4};
  }
  std::span<const std::byte> file_in_force() const noexcept override { return held; }

  Bytes held;
  std::uint32_t fingerprint = 5;
  int commits = 0;
  int busy = 0;
  int reverts = 0;
  SettingsResult answer = SettingsResult::kOk;
};

class Others final : public firmware::SettingsService {
 public:
  wire::SettingsAnswer serve(const wire::SettingsRequest& /*request*/,
                             std::span<const std::byte> /*text*/, const firmware::Requester& /*by*/,
                             std::span<std::byte> /*answer*/,
                             std::size_t& /*bytes*/) noexcept override {
    return {.result = SettingsResult::kUnsupported};
  }
};

// A sensor at the end of a cable. Each packet of either way has a number; `lost` says which never
// arrive.
class SensorOnCable final : public ControlTransport {
 public:
  struct World {
    Shelf shelf;
    Others others;
    std::optional<upload::UploadServer> server;
    std::function<bool(int)> lost = [](int) { return false; };
    std::function<void(wire::UploadAnswer&)> lie = [](wire::UploadAnswer&) {};
    int packets = 0;
    int restart_at = -1;
    std::deque<Bytes> waiting;
  };
  explicit SensorOnCable(World& world) : world_(world) {
    world.server.emplace(world.others, world.shelf);
  }

  Status send(std::span<const std::byte> packet) override {
    const int number = world_.packets++;
    if (number == world_.restart_at) {
      world_.server.emplace(world_.others, world_.shelf);
    }
    if (!world_.lost(number)) {
      answer(packet);
    }
    return Status::kOk;
  }
  Result<Bytes> receive(Duration /*timeout*/) override {
    if (world_.waiting.empty()) {
      return fail(Status::kTimeout);
    }
    Bytes packet = std::move(world_.waiting.front());
    world_.waiting.pop_front();
    return packet;
  }
  std::string place() const override { return "here"; }

 private:
  void answer(std::span<const std::byte> packet) {
    const auto parsed = wire::parse_packet(packet);
    ASSERT_TRUE(parsed);
    const auto asked = wire::decode_settings_request(parsed->payload);
    ASSERT_TRUE(asked);
    wire::DatagramBuffer buffer;
    const auto space = wire::payload_space(buffer);
    std::size_t bytes = 0;
    wire::SettingsAnswer out =
        world_.server->serve(*asked, parsed->payload.subspan(wire::kSettingsRequestBytes),
                             {.peer = {}, .access = firmware::Access::kAdmin},
                             space.subspan(wire::kSettingsAnswerBytes), bytes);
    out.request_id = asked->request_id;
    wire::encode_settings_answer(out, space.first<wire::kSettingsAnswerBytes>());
    const auto fields = space.subspan<wire::kSettingsAnswerBytes, wire::kUploadAnswerBytes>();
    if (out.result == SettingsResult::kOk) {
      wire::UploadAnswer said = *wire::decode_upload_answer(fields);
      world_.lie(said);
      wire::encode_upload_answer(said, fields);
    }
    const auto sealed =
        wire::seal_packet({.type = wire::PacketType::kSettingsAnswer, .origin = {.device_id = 1}},
                          wire::kSettingsAnswerBytes + bytes, buffer);
    if (!world_.lost(world_.packets++)) {
      world_.waiting.emplace_back(sealed.begin(), sealed.end());
    }
  }

  World& world_;
};

class UploadClientTest : public testing::Test {
 protected:
  void SetUp() override {
    ASSERT_TRUE(wire::start_crypto());
    for (std::size_t i = 0; i < file_.size(); ++i) {
      file_[i] = static_cast<std::byte>(i * 7 + i / 256);
    }
  }
  std::expected<UploadResult, ControlError> upload() {
    return uploads_.upload(wire::UploadKind::kCalibration, file_,
                           [this](std::size_t bytes, std::size_t) { seen_.push_back(bytes); });
  }

  Bytes file_ = Bytes(10'000);
  SensorOnCable::World world_;
  ControlClient client_{std::make_unique<SensorOnCable>(world_),
                        {.timeout = 1ms, .attempts = 2, .unsigned_answers = Unsigned::kAlways}};
  UploadClient uploads_{client_, 400ms};
  std::vector<std::size_t> seen_;
};

TEST_F(UploadClientTest, PutsAllOfItThereAndSaysHowFarItIs) {
  const auto done = upload();
  ASSERT_TRUE(done) << done.error().message;
  EXPECT_EQ(done->result, SettingsResult::kOk);
  EXPECT_EQ(done->fingerprint, 5U);
  EXPECT_EQ(done->former, 4U);
  EXPECT_EQ(world_.shelf.held, file_);
  EXPECT_EQ(world_.shelf.commits, 1);
  EXPECT_TRUE(std::ranges::is_sorted(seen_));
  EXPECT_EQ(seen_.front(), 0U);
  EXPECT_EQ(seen_.back(), file_.size());
}

// Of 10,000 bytes with their CRC behind, as a calibration file has it.
TEST_F(UploadClientTest, ReadsTheCalibrationFileInForceAndComparesIt) {
  world_.shelf.held = file_;
  world_.shelf.fingerprint = wire::crc32c(file_);
  std::array<std::byte, 4> crc{};
  wire::put_u32(crc, world_.shelf.fingerprint);
  world_.shelf.held.insert(world_.shelf.held.end(), crc.begin(), crc.end());
  const auto read = download_calibration(client_);
  ASSERT_TRUE(read) << read.error().message;
  EXPECT_TRUE(std::ranges::equal(std::as_bytes(std::span(*read)), world_.shelf.held));
  world_.lost = [](int number) { return number % 3 == 1; };
  ASSERT_TRUE(download_calibration(client_));
  world_.lost = [](int) { return false; };
  world_.shelf.held[5'000] ^= std::byte{1};  // what came is not what the sensor says it has
  const auto damaged = download_calibration(client_);
  ASSERT_FALSE(damaged);
  EXPECT_EQ(damaged.error().status, Status::kCorrupt);
  world_.shelf.held.clear();
  const auto none = download_calibration(client_);
  ASSERT_FALSE(none);
  EXPECT_EQ(none.error().status, Status::kUnsupported);
}

TEST_F(UploadClientTest, WhateverIsLostIsSentAgain) {
  for (int period = 3; period < 10; ++period) {
    world_.lost = [period](int number) { return number % period == 1; };
    world_.shelf.commits = 0;
    const auto done = upload();
    ASSERT_TRUE(done) << period << ": " << done.error().message;
    EXPECT_EQ(done->result, SettingsResult::kOk);
    EXPECT_EQ(world_.shelf.held, file_) << period;
    EXPECT_EQ(world_.shelf.commits, 1) << period;
  }
}

TEST_F(UploadClientTest, ASensorThatStartsAnewGetsAllOfItAgain) {
  for (int at = 0; at < 26; at += 2) {
    world_.packets = 0;
    world_.restart_at = at;
    const auto done = upload();
    ASSERT_TRUE(done) << at << ": " << done.error().message;
    EXPECT_EQ(world_.shelf.held, file_) << at;
  }
}

TEST_F(UploadClientTest, ABusySensorIsAskedAgainUntilThePatienceIsOver) {
  world_.shelf.busy = 1;
  EXPECT_EQ(upload()->result, SettingsResult::kOk);
  world_.shelf.busy = 1000;
  world_.shelf.commits = 0;
  EXPECT_EQ(upload()->result, SettingsResult::kBusy);
}

TEST_F(UploadClientTest, ARefusalIsOneLineThatCanBePrinted) {
  world_.shelf.answer = SettingsResult::kInvalid;
  const auto done = upload();
  ASSERT_TRUE(done);
  EXPECT_EQ(done->result, SettingsResult::kInvalid);
  EXPECT_EQ(done->text.find('\n'), std::string::npos);
}

TEST_F(UploadClientTest, SilenceEndsItWhenThePatienceIsOver) {
  world_.lost = [](int) { return true; };
  const auto done = upload();
  ASSERT_FALSE(done);
  EXPECT_EQ(done.error().status, Status::kTimeout);
}

TEST_F(UploadClientTest, AnswersThatContradictThemselvesEndIt) {
  const std::vector<std::function<void(wire::UploadAnswer&)>> lies{
      [](wire::UploadAnswer& answer) { answer.wanted = 0; },
      [](wire::UploadAnswer& answer) { answer.wanted = 20'000; },
      [](wire::UploadAnswer& answer) { answer.wanted %= 2000; },
      [](wire::UploadAnswer& answer) { answer.chunk = 0; }};
  for (const auto& lie : lies) {
    world_.lie = lie;
    const auto done = upload();
    ASSERT_FALSE(done);
    EXPECT_EQ(done.error().status, Status::kCorrupt);
  }
}

// Two programs with one key: whoever begins has the sensor forget what the other one sent.
TEST_F(UploadClientTest, AnotherFileWithTheSameKeyIsNamedAsTheReason) {
  ControlClient other{std::make_unique<SensorOnCable>(world_),
                      {.timeout = 1ms, .attempts = 2, .unsigned_answers = Unsigned::kAlways}};
  UploadClient others{other, 400ms};
  const auto done = uploads_.upload(
      wire::UploadKind::kCalibration, file_, [&](std::size_t /*bytes*/, std::size_t /*all*/) {
        EXPECT_TRUE(others.upload(wire::UploadKind::kCalibration, Bytes(500), {}));
      });
  ASSERT_FALSE(done);
  EXPECT_NE(done.error().message.find("another program with the same key"), std::string::npos)
      << done.error().message;
}

TEST_F(UploadClientTest, GoesBack) {
  const auto done = uploads_.revert(wire::UploadKind::kCalibration);
  ASSERT_TRUE(done);
  EXPECT_EQ(done->result, SettingsResult::kOk);
  EXPECT_EQ(world_.shelf.reverts, 1);
}

}  // namespace
}  // namespace stof::client
