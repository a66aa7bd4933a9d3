#pragma once

#include <cstddef>
#include <cstdint>
#include <expected>
#include <functional>
#include <span>
#include <string>

#include "firmware/wire/messages/upload_answer.h"
#include "firmware/wire/messages/upload_request.h"
#include "host/client/control/control_client.h"

namespace stof::client {

struct UploadResult {
  // kOk, or the sensor's last word.
  wire::SettingsResult result = wire::SettingsResult::kOk;
  std::string text{};             // of a refusal: one line that can be printed
  std::uint32_t fingerprint = 0;  // in force now
  std::uint32_t former = 0;       // before; of updates: in the other slot
  wire::UploadState state = wire::UploadState::kSettled;
};

// Puts something on a sensor, a chunk a request (docs/WIRE.md, "Uploads"); blocks. One chunk is in
// flight at a time, and the sensor says which one it wants: what is lost is sent again, and after
// an interruption, of this program too, it goes on where it stopped. For one thread.
class UploadClient {
 public:
  // Bytes that the sensor has, of all.
  using Progress = std::function<void(std::size_t bytes, std::size_t total)>;

  // client outlives it. patience: without an answer, or with a sensor that is busy, before it gives
  // up; what came so far is kept by the sensor for half a minute, in which other keys wait.
  explicit UploadClient(ControlClient& client, Duration patience = std::chrono::seconds(40))
      : client_(client), patience_(patience) {}

  // wire::start_crypto() has been called; bytes: below 4 GiB. Errors as ControlClient::request(),
  // kTimeout when the patience is over, kCorrupt: the answers contradict themselves.
  std::expected<UploadResult, ControlError> upload(wire::UploadKind kind,
                                                   std::span<const std::byte> bytes,
                                                   const Progress& progress = {});
  // What is in force; changes nothing. Of updates also what is in the other slot.
  std::expected<UploadResult, ControlError> state_of(wire::UploadKind kind);
  // Back to what was there before the first upload.
  std::expected<UploadResult, ControlError> revert(wire::UploadKind kind);

 private:
  struct Step {
    UploadResult result;
    wire::UploadAnswer answer;  // where the result is kOk
  };
  std::expected<UploadResult, ControlError> ask_alone(wire::UploadKind kind, wire::UploadStep step);
  // Asks until there is an answer that is not "busy".
  std::expected<Step, ControlError> ask(const wire::UploadRequest& request,
                                        std::span<const std::byte> chunk);

  ControlClient& client_;
  Duration patience_;
};

}  // namespace stof::client
