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

inline constexpr std::size_t kHeaderFieldsBytes = 52;

// Header: of every packet, before its payload.
struct HeaderFields {
  PacketType type = PacketType{};  // see "Types"
  std::uint8_t flags = 0;  // bits 0 to 3: scale of a tile of depth or width (see "Tiles"), else 0.
                           // Bit 4: a tile of source is told in steps. Bits 5 to 7 are reserved
  Origin origin{};         // origin
  Stream stream = Stream{};         // see "Streams"; 0 outside tiles
  Codec codec = Codec{};            // see "Streams"; 0 outside tiles
  Health health = Health{};         // summary of the sensor: 0 good, 1 degraded, 2 fault
  ClockState clock = ClockState{};  // what times count from: 0 the sensor's own monotonic clock,
                                    // synchronised with nothing; 1 the time of an emulated rig
  std::uint32_t number =
      0;  // of the frame: advances by one with each frame sent, wraps from 2^32 - 1 to 0
  std::int64_t exposure_middle_ns = 0;  // ns: middle of the exposure of the stereo pair
  std::uint32_t freshness = 0;          // see "Freshness"
  std::uint16_t index = 0;              // of the packet, from 0, below the count
  std::uint16_t count = 1;              // packets of the frame, at least 1
  std::uint16_t image_width =
      0;  // pixels, of the whole image of the stream; outside tiles of the depth image
  std::uint16_t image_height = 0;    // rows, likewise
  std::uint16_t first_row = 0;       // of a tile; 0 in other types, as the next two
  std::uint16_t first_column = 0;    // of a tile
  std::uint16_t pixel_count = 0;     // of a tile
  std::uint16_t payload_length = 0;  // P
};

void encode_header_fields(const HeaderFields& value,
                          std::span<std::byte, kHeaderFieldsBytes> out) noexcept;
// kCorrupt: shorter than kHeaderFieldsBytes. What follows is of a newer sender and ignored.
Result<HeaderFields> decode_header_fields(std::span<const std::byte> payload) noexcept;

}  // namespace stof::wire
