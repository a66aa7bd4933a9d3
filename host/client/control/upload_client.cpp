#include "host/client/control/upload_client.h"

#include <algorithm>
#include <array>
#include <optional>
#include <string_view>
#include <thread>
#include <utility>

#include "firmware/wire/crypto/crypto.h"
#include "host/client/printable.h"

namespace stof::client {
namespace {

using wire::SettingsResult;
using wire::UploadStep;

constexpr Duration kCommitPause = std::chrono::milliseconds(250);
constexpr Duration kChunkPause = std::chrono::milliseconds(20);
// Answers in a row of a sensor that wants nothing further than it did once, beside those that
// bring it there again when it has started anew.
constexpr std::size_t kMostStandstills = 20;

std::span<const std::byte> bytes_of(const std::string& text) {
  return std::as_bytes(std::span(text));
}

ControlError contradiction() {
  return {.status = Status::kCorrupt,
          .message =
              "the sensor's answers contradict themselves: update this program or the "
              "sensor"};
}

ControlError standstill() {
  return {.status = Status::kCorrupt,
          .message =
              "the sensor has it begin again and again: another program with the same key puts "
              "another file there, or the sensor keeps starting anew: end that, then try again"};
}

}  // namespace

std::expected<UploadClient::Step, ControlError> UploadClient::ask(
    const wire::UploadRequest& request, std::span<const std::byte> chunk) {
  std::string text(wire::kUploadRequestBytes + chunk.size(), '\0');
  const std::span<std::byte> to = std::as_writable_bytes(std::span(text));
  wire::encode_upload_request(request, to.first<wire::kUploadRequestBytes>());
  std::ranges::copy(chunk, to.subspan(wire::kUploadRequestBytes).begin());
  const Time begin = Time::clock::now();
  for (;;) {
    auto answer = client_.exchange(wire::SettingsOperation::kUpload, text);
    const bool over = Time::clock::now() - begin >= patience_;
    if (!answer) {
      if (answer.error().status != Status::kTimeout || over) {
        return std::unexpected(std::move(answer.error()));
      }
      continue;
    }
    if (answer->result == SettingsResult::kBusy && !over) {
      std::this_thread::sleep_for(request.step == UploadStep::kChunk ? kChunkPause : kCommitPause);
      continue;
    }
    if (answer->result != SettingsResult::kOk) {
      return Step{.result = {.result = answer->result, .text = printable(answer->text)},
                  .answer = {}};
    }
    const Result<wire::UploadAnswer> read = wire::decode_upload_answer(bytes_of(answer->text));
    if (!read) {
      return std::unexpected(contradiction());
    }
    return Step{.result = {.fingerprint = read->fingerprint,
                           .former = read->former,
                           .state = static_cast<wire::UploadState>(read->state)},
                .answer = *read};
  }
}

std::expected<UploadResult, ControlError> UploadClient::upload(wire::UploadKind kind,
                                                               std::span<const std::byte> bytes,
                                                               const Progress& progress) {
  wire::UploadRequest request{.step = UploadStep::kBegin,
                              .kind = static_cast<std::uint8_t>(kind),
                              .total = static_cast<std::uint32_t>(bytes.size())};
  const wire::Digest hash = wire::digest_of({}, {bytes});
  std::ranges::transform(hash, request.hash.begin(),
                         [](std::byte byte) { return std::to_integer<std::uint8_t>(byte); });
  std::uint32_t furthest = 0;
  std::size_t standstills = 0;
  std::span<const std::byte> chunk;
  for (;;) {
    auto step = ask(request, chunk);
    if (!step) {
      return std::unexpected(std::move(step.error()));
    }
    const std::uint32_t wanted = step->answer.wanted;
    const bool all = wanted == request.total;
    if (step->result.result != SettingsResult::kOk ||
        (request.step == UploadStep::kCommit && all)) {
      return step->result;
    }
    // A sensor that started anew begins at 0, which may not go on for ever either.
    standstills = wanted > furthest ? 0 : standstills + 1;
    furthest = std::max(furthest, wanted);
    const std::size_t most =
        kMostStandstills + std::size_t{furthest} / std::max<std::size_t>(step->answer.chunk, 1);
    if (wanted > request.total || step->answer.chunk == 0) {
      return std::unexpected(contradiction());
    }
    if (standstills > most) {
      return std::unexpected(standstill());
    }
    if (progress) {
      progress(wanted, bytes.size());
    }
    const std::size_t room = ControlClient::kMaxText - wire::kUploadRequestBytes;
    request.step = all ? UploadStep::kCommit : UploadStep::kChunk;
    request.offset = wanted;
    const std::span<const std::byte> rest = bytes.subspan(wanted);
    chunk = rest.first(std::min({rest.size(), room, std::size_t{step->answer.chunk}}));
  }
}

std::expected<UploadResult, ControlError> UploadClient::ask_alone(wire::UploadKind kind,
                                                                  UploadStep step) {
  auto answer = ask({.step = step, .kind = static_cast<std::uint8_t>(kind)}, {});
  if (!answer) {
    return std::unexpected(std::move(answer.error()));
  }
  return answer->result;
}

std::expected<UploadResult, ControlError> UploadClient::revert(wire::UploadKind kind) {
  return ask_alone(kind, UploadStep::kRevert);
}

std::expected<UploadResult, ControlError> UploadClient::state_of(wire::UploadKind kind) {
  return ask_alone(kind, UploadStep::kAsk);
}

}  // namespace stof::client
