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

inline constexpr std::size_t kSettingsAnswerBytes = 24;

// Type 133. The text follows, up to the end of the payload.
struct SettingsAnswer {
  std::uint32_t request_id = 0;              // of the request
  SettingsResult result = SettingsResult{};  // see "Settings"
  std::uint8_t restart = 0;    // 1: some of the active settings wait for the next start
  std::uint16_t total = 0;     // of get: length of the document, bytes
  std::uint32_t revision = 0;  // of the active settings: advances with every change
  std::uint64_t cookie = 0;    // for the next request
};

void encode_settings_answer(const SettingsAnswer& value,
                            std::span<std::byte, kSettingsAnswerBytes> out) noexcept;
// kCorrupt: shorter than kSettingsAnswerBytes. What follows is of a newer sender and ignored.
Result<SettingsAnswer> decode_settings_answer(std::span<const std::byte> payload) noexcept;

}  // namespace stof::wire
