#include "host/client/control/download.h"

#include <array>
#include <cstddef>
#include <optional>
#include <span>
#include <utility>

#include "firmware/wire/calibration/calibration_file.h"
#include "firmware/wire/crc32c.h"
#include "firmware/wire/messages/download_answer.h"
#include "firmware/wire/messages/download_request.h"

namespace stof::client {
namespace {

constexpr std::size_t kMostFileBytes = std::size_t{64} << 20;  // of what is believed

std::unexpected<ControlError> download_error(Status status, std::string line) {
  return std::unexpected(ControlError{status, "calibration: " + std::move(line)});
}

// From `offset` on: the answer and the bytes behind it.
std::expected<std::pair<wire::DownloadAnswer, std::string>, ControlError> part_from(
    ControlClient& client, std::size_t offset) {
  std::array<std::byte, wire::kDownloadRequestBytes> request{};
  wire::encode_download_request({.kind = static_cast<std::uint8_t>(wire::UploadKind::kCalibration),
                                 .offset = static_cast<std::uint32_t>(offset)},
                                request);
  auto answer = client.exchange(wire::SettingsOperation::kDownload,
                                {reinterpret_cast<const char*>(request.data()), request.size()});
  if (!answer) {
    return std::unexpected(std::move(answer.error()));
  }
  if (answer->result != wire::SettingsResult::kOk) {
    return download_error(Status::kUnsupported, "the sensor does not give its file: update it");
  }
  const auto head = wire::decode_download_answer(std::as_bytes(std::span(answer->text)));
  if (!head || head->offset != offset) {
    return download_error(Status::kCorrupt, "the sensor's answer contradicts itself");
  }
  return std::pair(*head, answer->text.substr(wire::kDownloadAnswerBytes));
}

// A calibration file ends with its CRC, which is its fingerprint.
bool sound(std::span<const std::byte> file, std::uint32_t fingerprint) {
  return file.size() > sizeof(std::uint32_t) &&
         wire::calibration_fingerprint(file) == fingerprint &&
         wire::crc32c(file.first(file.size() - sizeof(std::uint32_t))) == fingerprint;
}

}  // namespace

std::expected<std::string, ControlError> download_calibration(ControlClient& client) {
  std::string file;
  std::optional<wire::DownloadAnswer> first;
  for (int restarts = 0; restarts < 3;) {
    auto part = part_from(client, file.size());
    if (!part) {
      return std::unexpected(std::move(part.error()));
    }
    const wire::DownloadAnswer& head = part->first;
    first = first.value_or(head);
    if (head.total != first->total || head.fingerprint != first->fingerprint) {
      file.clear();  // another one was installed meanwhile
      first.reset();
      ++restarts;
      continue;
    }
    file += part->second;
    if (file.size() == head.total) {
      const auto bytes = std::as_bytes(std::span(file));
      return sound(bytes, head.fingerprint)
                 ? std::expected<std::string, ControlError>(std::move(file))
                 : download_error(Status::kCorrupt, "what came is not what the sensor has");
    }
    if (part->second.empty() || file.size() > head.total || head.total > kMostFileBytes) {
      return download_error(Status::kCorrupt, "the sensor's answer contradicts itself");
    }
  }
  return download_error(Status::kTimeout, "it changed while it was read: try again");
}

}  // namespace stof::client
