#include "firmware/wire/packet.h"

#include <algorithm>

#include "dsp/base/check.h"
#include "firmware/wire/bytes.h"
#include "firmware/wire/crc32c.h"

namespace stof::wire {
namespace {

constexpr std::array<std::byte, 4> kMagic{std::byte{'S'}, std::byte{'T'}, std::byte{'O'},
                                          std::byte{'F'}};

// docs/WIRE.md, "Header".
void write_header(const Header& header, std::size_t payload_bytes,
                  std::span<std::byte, kHeaderBytes> out) noexcept {
  std::ranges::copy(kMagic, out.begin());
  put_u8(out.subspan<4, 1>(), kWireVersion);
  put_u8(out.subspan<5, 1>(), static_cast<std::uint8_t>(header.type));
  put_u8(out.subspan<6, 1>(), static_cast<std::uint8_t>(kHeaderBytes));
  put_u8(out.subspan<7, 1>(), header.flags);
  put_u32(out.subspan<8, 4>(), header.origin.device_id);
  put_u32(out.subspan<12, 4>(), header.origin.session_id);
  put_u8(out.subspan<16, 1>(), static_cast<std::uint8_t>(header.stream));
  put_u8(out.subspan<17, 1>(), static_cast<std::uint8_t>(header.codec));
  put_u8(out.subspan<18, 1>(), static_cast<std::uint8_t>(header.frame.health));
  put_u8(out.subspan<19, 1>(), static_cast<std::uint8_t>(header.frame.clock));
  put_u32(out.subspan<20, 4>(), header.frame.number);
  put_i64(out.subspan<24, 8>(), header.frame.exposure_middle_ns);
  put_u32(out.subspan<32, 4>(), header.frame.freshness);
  put_u16(out.subspan<36, 2>(), header.index);
  put_u16(out.subspan<38, 2>(), header.count);
  put_u16(out.subspan<40, 2>(), header.image_width);
  put_u16(out.subspan<42, 2>(), header.image_height);
  put_u16(out.subspan<44, 2>(), header.first_row);
  put_u16(out.subspan<46, 2>(), header.first_column);
  put_u16(out.subspan<48, 2>(), header.pixel_count);
  put_u16(out.subspan<50, 2>(), static_cast<std::uint16_t>(payload_bytes));
}

Header read_header(std::span<const std::byte, kHeaderBytes> in) noexcept {
  return {
      .type = PacketType{get_u8(in.subspan<5, 1>())},
      .flags = get_u8(in.subspan<7, 1>()),
      .origin = {.device_id = get_u32(in.subspan<8, 4>()),
                 .session_id = get_u32(in.subspan<12, 4>())},
      .frame = {.number = get_u32(in.subspan<20, 4>()),
                .freshness = get_u32(in.subspan<32, 4>()),
                .exposure_middle_ns = get_i64(in.subspan<24, 8>()),
                .health = Health{get_u8(in.subspan<18, 1>())},
                .clock = ClockState{get_u8(in.subspan<19, 1>())}},
      .stream = Stream{get_u8(in.subspan<16, 1>())},
      .codec = Codec{get_u8(in.subspan<17, 1>())},
      .index = get_u16(in.subspan<36, 2>()),
      .count = get_u16(in.subspan<38, 2>()),
      .image_width = get_u16(in.subspan<40, 2>()),
      .image_height = get_u16(in.subspan<42, 2>()),
      .first_row = get_u16(in.subspan<44, 2>()),
      .first_column = get_u16(in.subspan<46, 2>()),
      .pixel_count = get_u16(in.subspan<48, 2>()),
  };
}

}  // namespace

const char* to_string(PacketFault fault) noexcept {
  switch (fault) {
    case PacketFault::kTruncated:
      return "truncated";
    case PacketFault::kMagic:
      return "wrong magic";
    case PacketFault::kVersion:
      return "unknown version";
    case PacketFault::kLength:
      return "wrong length";
    case PacketFault::kCrc:
      return "wrong CRC";
    case PacketFault::kField:
      return "contradicting fields";
  }
  return "unknown fault";
}

std::expected<PacketView, PacketFault> parse_packet(std::span<const std::byte> datagram) noexcept {
  if (datagram.size() < kHeaderBytes + kCrcBytes) {
    return std::unexpected(PacketFault::kTruncated);
  }
  if (!std::ranges::equal(datagram.first<4>(), kMagic)) {
    return std::unexpected(PacketFault::kMagic);
  }
  if (get_u8(datagram.subspan<4, 1>()) != kWireVersion) {
    return std::unexpected(PacketFault::kVersion);
  }
  const std::size_t header_bytes = get_u8(datagram.subspan<6, 1>());
  if (header_bytes < kHeaderBytes) {
    return std::unexpected(PacketFault::kLength);
  }
  const std::size_t payload_bytes = get_u16(datagram.subspan<50, 2>());
  const std::size_t stated = header_bytes + payload_bytes + kCrcBytes;
  if (datagram.size() < stated) {
    return std::unexpected(PacketFault::kTruncated);
  }
  if (datagram.size() > stated || stated > kMaxDatagram) {
    return std::unexpected(PacketFault::kLength);
  }
  if (crc32c(datagram.first(stated - kCrcBytes)) != get_u32(datagram.last<kCrcBytes>())) {
    return std::unexpected(PacketFault::kCrc);
  }
  const PacketView packet{.header = read_header(datagram.first<kHeaderBytes>()),
                          .payload = datagram.subspan(header_bytes, payload_bytes)};
  if (packet.header.index >= packet.header.count) {
    return std::unexpected(PacketFault::kField);
  }
  return packet;
}

std::span<const std::byte> seal_packet(const Header& header, std::size_t payload_bytes,
                                       DatagramBuffer& buffer) noexcept {
  STOF_CHECK(payload_bytes <= kMaxPayload);
  const std::span<std::byte, kMaxDatagram> bytes(buffer);
  write_header(header, payload_bytes, bytes.first<kHeaderBytes>());
  const std::span<std::byte> covered = bytes.first(kHeaderBytes + payload_bytes);
  const std::span<std::byte> crc = bytes.subspan(covered.size(), kCrcBytes);
  put_u32(crc.first<kCrcBytes>(), crc32c(covered));
  return bytes.first(covered.size() + kCrcBytes);
}

bool consistent_tile(const PacketView& packet) noexcept {
  const Header& header = packet.header;
  const std::size_t width = header.image_width;
  const std::size_t first = header.first_row * width + header.first_column;
  return header.pixel_count > 0 && header.first_column < width &&
         first + header.pixel_count <= width * header.image_height &&
         packet.payload.size() == header.pixel_count * pixel_bytes(header.stream, header.codec);
}

}  // namespace stof::wire
