#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <expected>
#include <span>

#include "firmware/wire/messages/enums.h"
#include "firmware/wire/messages/structs.h"
#include "hal/datagram_size.h"

// One datagram: header, payload, CRC-32C. The bytes are described in docs/WIRE.md.
namespace stof::wire {

using hal::kMaxDatagram;
inline constexpr std::size_t kHeaderBytes = 52;  // of version 1, without the CRC
inline constexpr std::size_t kCrcBytes = 4;
inline constexpr std::size_t kMaxPayload = kMaxDatagram - kHeaderBytes - kCrcBytes;
inline constexpr std::uint8_t kWireVersion = 1;

inline constexpr std::size_t kStreams = 8;  // streams 1 to 8; index: number less 1

// Types below 64 are parts of a frame and share its packet counting; the others count for
// themselves.
constexpr bool part_of_frame(PacketType type) noexcept {
  return static_cast<std::uint8_t>(type) < 64;
}

// The fields that all packets of a frame have in common.
struct FrameStamp {
  std::uint32_t number = 0;     // advances by one with each frame sent, wraps
  std::uint32_t freshness = 0;  // advances only on a verified new exposure of all cameras; from 1
  std::int64_t exposure_middle_ns = 0;
  Health health = Health::kOk;
  ClockState clock = ClockState::kMonotonic;
};

struct Header {
  PacketType type = PacketType::kTile;
  // Bits 0 to 3 of a tile of depth or width: its values stand for what is 1 << scale times as
  // large. Bit 4 of a tile of source: its values are exclusive ors (kXorDeltaFlag). The others are
  // sent as 0 and ignored.
  std::uint8_t flags = 0;
  Origin origin{};
  FrameStamp frame{};
  Stream stream = Stream::kNone;
  Codec codec = Codec::kNone;
  std::uint16_t index = 0;  // < count
  std::uint16_t count = 1;
  std::uint16_t image_width = 0;
  std::uint16_t image_height = 0;
  // Tiles only, else 0: pixel_count pixels in raster order from (first_column, first_row).
  std::uint16_t first_row = 0;
  std::uint16_t first_column = 0;
  std::uint16_t pixel_count = 0;
};

// Why bytes are not a packet; the first reason that applies, in this order.
enum class PacketFault : std::uint8_t {
  kTruncated,  // shorter than a header with CRC, or than its own lengths say
  kMagic,      // not ours
  kVersion,    // ours, of a layout this code does not know
  kLength,     // longer than its own lengths say, than kMaxDatagram, or a header below kHeaderBytes
  kCrc,        // damaged on the way
  kField,      // undamaged, but it contradicts itself: a sender's bug
};

struct PacketView {
  Header header;
  std::span<const std::byte> payload;  // into the bytes that were parsed
  std::uint32_t crc = 0;               // of its datagram; 0: it came in none, parity made it
};

// The CRC of the datagram that a sender of this version makes of it.
std::uint32_t plain_crc(const PacketView& packet) noexcept;

// Any bytes; reads nothing outside them. Verified packets only.
std::expected<PacketView, PacketFault> parse_packet(std::span<const std::byte> datagram) noexcept;

using DatagramBuffer = std::array<std::byte, kMaxDatagram>;

// Where the payload of a datagram belongs before seal_packet().
constexpr std::span<std::byte, kMaxPayload> payload_space(DatagramBuffer& buffer) noexcept {
  return std::span<std::byte, kMaxDatagram>(buffer).subspan<kHeaderBytes, kMaxPayload>();
}

// Writes the header before and the CRC behind `payload_bytes` (at most kMaxPayload) that already
// lie in payload_space(buffer). Returns the datagram, a part of `buffer`.
std::span<const std::byte> seal_packet(const Header& header, std::size_t payload_bytes,
                                       DatagramBuffer& buffer) noexcept;

// Bytes of one pixel of a raw tile; 0 for other codecs.
constexpr std::size_t raw_pixel_bytes(Codec codec) noexcept {
  switch (codec) {
    case Codec::kRaw16:
      return 2;
    case Codec::kRaw8:
      return 1;
    case Codec::kPoints:
      return 8;
    default:
      return 0;
  }
}

constexpr unsigned scale_of(const Header& header) noexcept { return header.flags & 0x0FU; }
// Whether a pixel is sent as its exclusive or with the one left of it; the first of the tile and of
// each row is sent as it is.
inline constexpr std::uint8_t kXorDeltaFlag = 0x10;
constexpr bool is_xor_delta(const Header& header) noexcept {
  return (header.flags & kXorDeltaFlag) != 0;
}

// Bytes that a pixel of a stream has in memory: 1, 2 or 8; 0 for a stream or codec this code does
// not know, or a pair of them that does not belong together.
std::size_t pixel_bytes(Stream stream, Codec codec) noexcept;

// Whether a tile of a known stream and codec lies in its image, has a scale or exclusive ors only
// where there are such, and has as many bytes as it says; how many an RVL tile has to have only its
// decoder knows.
bool consistent_tile(const PacketView& packet) noexcept;

}  // namespace stof::wire
