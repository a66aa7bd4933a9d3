// Made by scripts/wire_table.py of firmware/wire/messages.json: change that.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

#include "dsp/base/status.h"
#include "firmware/wire/messages/enums.h"
#include "firmware/wire/messages/structs.h"

namespace stof::wire {

inline constexpr std::size_t kSettingsRequestBytes = 24;

// Type 132. The text follows, up to the end of the payload, at most 1,024 bytes.
struct SettingsRequest {
  std::uint32_t request_id = 0;                       // any number, comes back in the answer
  SettingsOperation operation = SettingsOperation{};  // see "Settings"
  SettingsDocument document = SettingsDocument{};     // of get
  std::uint16_t offset = 0;  // of get: where the answer's text begins in the document, bytes
  std::uint64_t cookie = 0;  // of an answer; 0: none yet. Not looked at on serial lines
};

void encode_settings_request(const SettingsRequest& value,
                             std::span<std::byte, kSettingsRequestBytes> out) noexcept;
// kCorrupt: shorter than kSettingsRequestBytes. What follows is of a newer sender and ignored.
Result<SettingsRequest> decode_settings_request(std::span<const std::byte> payload) noexcept;

}  // namespace stof::wire
