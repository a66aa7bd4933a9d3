#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>

#include "firmware/control/settings_service.h"
#include "firmware/upload/upload_target.h"
#include "firmware/wire/crypto/crypto.h"
#include "firmware/wire/keys/key_table.h"
#include "firmware/wire/messages/download_answer.h"
#include "firmware/wire/messages/download_request.h"
#include "firmware/wire/messages/upload_answer.h"
#include "firmware/wire/messages/upload_request.h"
#include "hal/time.h"

namespace stof::upload {

// Serves the operations upload and download (docs/WIRE.md, "Uploads", "Downloads"), and leaves all
// others to who serves settings. One upload at a time, of one key: its bytes come in their order,
// and the hash is that of what came. Every request names the whole upload (kind, total, hash), so
// that any of them takes up one that is under way, and begins one that is not: a client that starts
// anew, or hears nothing, asks what is wanted and goes on there. For the control thread alone; no
// heap.
class UploadServer final : public firmware::SettingsService {
 public:
  // Of one request.
  static constexpr std::size_t kChunkBytes = 960;
  // An upload of which nothing was heard for so long holds up no other one: the next that is begun
  // takes its place. Until then it goes on where it stopped, however late.
  static constexpr hal::Duration kPatience = std::chrono::seconds(30);

  // All outlive it. update: nullptr: this sensor takes none.
  UploadServer(firmware::SettingsService& others, Target& calibration,
               Target* update = nullptr) noexcept
      : others_(others), calibration_(calibration), update_(update) {}

  // kDenied: it takes Access::kAdmin. kBusy: another key uploads, or the target says so.
  // kUnsupported: no such kind. kInvalid: no such request, a chunk that ends behind the whole,
  // another hash, or what the target says; a chunk that is not the one that is wanted is no error,
  // and changes nothing.
  wire::SettingsAnswer serve(const wire::SettingsRequest& request, std::span<const std::byte> text,
                             const firmware::Requester& by, std::span<std::byte> answer_text,
                             std::size_t& answer_bytes) noexcept override;

  // Nothing goes on of an upload whose key is none of these any more.
  void drop_ended_keys(const wire::KeyTable& keys) noexcept;

 private:
  using Result = wire::SettingsResult;
  enum class Phase : std::uint8_t { kNone, kRunning, kOver };
  // One upload, and whose it is.
  struct Identity {
    std::uint8_t kind = 0;
    std::uint32_t total = 0;
    wire::Digest hash{};
    std::uint32_t key_id = 0;  // 0: the cable

    friend bool operator==(const Identity&, const Identity&) = default;
  };

  Result serve(const wire::UploadRequest& request, std::span<const std::byte> bytes,
               const firmware::Requester& by, settings::PagedWriter& why) noexcept;
  // Bytes of the answer; 0: refused.
  std::size_t download(std::span<const std::byte> text, std::span<std::byte> answer_text,
                       Result& result, settings::PagedWriter& why) const noexcept;
  Target* target_of(std::uint8_t kind) const noexcept;
  Result begin(const Identity& upload, settings::PagedWriter& why) noexcept;
  Result take(std::uint32_t offset, std::span<const std::byte> bytes,
              settings::PagedWriter& why) noexcept;
  Result commit(const firmware::Requester& by, settings::PagedWriter& why) noexcept;
  Result end(Result result, settings::PagedWriter& why) noexcept;

  firmware::SettingsService& others_;
  Target& calibration_;
  Target* update_;
  Phase phase_ = Phase::kNone;
  Identity upload_;
  std::uint32_t wanted_ = 0;
  hal::Time heard_{};
  wire::StreamingDigest digest_;
  // How it ended: the same answer to whoever did not hear it.
  Result ended_ = Result::kOk;
  std::array<char, 240> told_{};
  std::size_t told_bytes_ = 0;
};

}  // namespace stof::upload
