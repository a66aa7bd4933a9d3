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

inline constexpr std::size_t kParityFieldsBytes = 18;

// Type 66. After these fields the exclusive or of the payloads of the group, each filled up with 0
// to the longest.
struct ParityFields {
  std::uint16_t count = 0;        // packets of the frame, as in the headers of its parts
  std::uint8_t type = 0;          // exclusive or over the group's packets, as all that follow: type
  std::uint8_t flags = 0;         // flags
  std::uint8_t stream = 0;        // stream
  std::uint8_t codec = 0;         // codec
  std::uint16_t image_width = 0;  // image width
  std::uint16_t image_height = 0;    // image height
  std::uint16_t first_row = 0;       // first row
  std::uint16_t first_column = 0;    // first column
  std::uint16_t pixel_count = 0;     // pixel count
  std::uint16_t payload_length = 0;  // payload length
};

void encode_parity_fields(const ParityFields& value,
                          std::span<std::byte, kParityFieldsBytes> out) noexcept;
// kCorrupt: shorter than kParityFieldsBytes. What follows is of a newer sender and ignored.
Result<ParityFields> decode_parity_fields(std::span<const std::byte> payload) noexcept;

}  // namespace stof::wire
