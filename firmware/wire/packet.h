#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <expected>
#include <span>

// One datagram: header, payload, CRC-32C. The bytes are described in docs/WIRE.md.
namespace stof::wire {

inline constexpr std::size_t kMaxDatagram = 1232;  // of UDP payload: never an IP fragment
inline constexpr std::size_t kHeaderBytes = 52;    // of version 1, without the CRC
inline constexpr std::size_t kCrcBytes = 4;
inline constexpr std::size_t kMaxPayload = kMaxDatagram - kHeaderBytes - kCrcBytes;
inline constexpr std::uint8_t kWireVersion = 1;

// The enumerations hold what arrived: a value without a name is legal and means "newer than this
// code". It is ignored and counted, never an error.

// Types below 64 are parts of a frame and share its packet counting; the others count for
// themselves.
enum class PacketType : std::uint8_t { kTile = 1, kFrameInfo = 2, kCalibration = 64, kHealth = 65 };
constexpr bool part_of_frame(PacketType type) noexcept {
  return static_cast<std::uint8_t>(type) < 64;
}

enum class Stream : std::uint8_t {
  kNone = 0,
  kDepth = 1,      // u16, quarter millimetres, Z; 0 = none
  kWidth = 2,      // u16, quarter millimetres, of the interval; 0 where depth is none
  kSource = 3,     // u8, dsp::Source
  kDisparity = 4,  // reserved: i16, 1/16 px, INT16_MIN = none
};

enum class Codec : std::uint8_t { kNone = 0, kRaw16 = 1, kRaw8 = 2 };

enum class Health : std::uint8_t { kOk = 0, kDegraded = 1, kFault = 2 };

// What the times of a packet count from.
enum class ClockState : std::uint8_t {
  kMonotonic = 0,  // nanoseconds since the sensor's boot, synchronised with nothing
  kEmulated = 1,   // an emulated rig's own time
};

struct Origin {
  std::uint32_t device_id = 0;
  std::uint32_t session_id = 0;  // random, new at each start of the sender
};

// What all packets of a frame say alike.
struct FrameStamp {
  std::uint32_t number = 0;     // advances by one with each frame sent, wraps
  std::uint32_t freshness = 0;  // advances only on a verified new exposure of all cameras; from 1
  std::int64_t exposure_middle_ns = 0;
  Health health = Health::kOk;
  ClockState clock = ClockState::kMonotonic;
};

struct Header {
  PacketType type = PacketType::kTile;
  std::uint8_t flags = 0;  // none defined: sent as 0, ignored
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
const char* to_string(PacketFault fault) noexcept;

struct PacketView {
  Header header;
  std::span<const std::byte> payload;  // into the bytes that were parsed
};

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

// Bytes of one pixel of a tile; 0 for a stream or codec this code does not know, or a pair of them
// that does not belong together.
constexpr std::size_t pixel_bytes(Stream stream, Codec codec) noexcept {
  const bool wide = stream == Stream::kDepth || stream == Stream::kWidth;
  if (wide && codec == Codec::kRaw16) {
    return 2;
  }
  return stream == Stream::kSource && codec == Codec::kRaw8 ? 1 : 0;
}

// Whether a tile of a known stream and codec lies in its image and has as many bytes as it says.
bool consistent_tile(const PacketView& packet) noexcept;

}  // namespace stof::wire
