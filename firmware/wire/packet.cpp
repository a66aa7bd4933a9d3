#include "firmware/wire/packet.h"

#include <algorithm>

#include "dsp/base/check.h"
#include "firmware/wire/bytes.h"
#include "firmware/wire/crc32c.h"
#include "firmware/wire/messages/header.h"

namespace stof::wire {
namespace {

constexpr std::array<std::byte, 4> kMagic{std::byte{'S'}, std::byte{'T'}, std::byte{'O'},
                                          std::byte{'F'}};
static_assert(kHeaderBytes == kHeaderFieldsBytes);

HeaderFields fields_of(const Header& header, std::size_t payload_bytes) noexcept {
  return {.type = header.type,
          .flags = header.flags,
          .origin = header.origin,
          .stream = header.stream,
          .codec = header.codec,
          .health = header.frame.health,
          .clock = header.frame.clock,
          .number = header.frame.number,
          .exposure_middle_ns = header.frame.exposure_middle_ns,
          .freshness = header.frame.freshness,
          .index = header.index,
          .count = header.count,
          .image_width = header.image_width,
          .image_height = header.image_height,
          .first_row = header.first_row,
          .first_column = header.first_column,
          .pixel_count = header.pixel_count,
          .payload_length = static_cast<std::uint16_t>(payload_bytes)};
}

Header header_of(const HeaderFields& fields) noexcept {
  return {.type = fields.type,
          .flags = fields.flags,
          .origin = fields.origin,
          .frame = {.number = fields.number,
                    .freshness = fields.freshness,
                    .exposure_middle_ns = fields.exposure_middle_ns,
                    .health = fields.health,
                    .clock = fields.clock},
          .stream = fields.stream,
          .codec = fields.codec,
          .index = fields.index,
          .count = fields.count,
          .image_width = fields.image_width,
          .image_height = fields.image_height,
          .first_row = fields.first_row,
          .first_column = fields.first_column,
          .pixel_count = fields.pixel_count};
}

}  // namespace

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
  const std::uint32_t crc = get_u32(datagram.last<kCrcBytes>());
  if (crc32c(datagram.first(stated - kCrcBytes)) != crc) {
    return std::unexpected(PacketFault::kCrc);
  }
  const Result<HeaderFields> fields = decode_header_fields(datagram);
  if (!fields) {
    return std::unexpected(PacketFault::kTruncated);
  }
  const PacketView packet{.header = header_of(*fields),
                          .payload = datagram.subspan(header_bytes, payload_bytes),
                          .crc = crc};
  if (packet.header.index >= packet.header.count) {
    return std::unexpected(PacketFault::kField);
  }
  return packet;
}

std::uint32_t plain_crc(const PacketView& packet) noexcept {
  std::array<std::byte, kHeaderBytes> header;
  encode_header_fields(fields_of(packet.header, packet.payload.size()), header);
  return crc32c(packet.payload, crc32c(header));
}

std::span<const std::byte> seal_packet(const Header& header, std::size_t payload_bytes,
                                       DatagramBuffer& buffer) noexcept {
  STOF_CHECK(payload_bytes <= kMaxPayload);
  const std::span<std::byte, kMaxDatagram> bytes(buffer);
  encode_header_fields(fields_of(header, payload_bytes), bytes.first<kHeaderBytes>());
  const std::span<std::byte> covered = bytes.first(kHeaderBytes + payload_bytes);
  const std::span<std::byte> crc = bytes.subspan(covered.size(), kCrcBytes);
  put_u32(crc.first<kCrcBytes>(), crc32c(covered));
  return bytes.first(covered.size() + kCrcBytes);
}

std::size_t pixel_bytes(Stream stream, Codec codec) noexcept {
  switch (stream) {
    case Stream::kDepth:
    case Stream::kWidth:
    case Stream::kDisparity:
    case Stream::kPmdRaw:
      return codec == Codec::kRaw16 || codec == Codec::kRvl16 ? 2 : 0;
    case Stream::kSource:
    case Stream::kGreyLeft:
    case Stream::kGreyRight:
      return codec == Codec::kRaw8 || codec == Codec::kRvl8 ? 1 : 0;
    case Stream::kCloud:
      return codec == Codec::kPoints ? 8 : 0;
    default:
      return 0;
  }
}

bool consistent_tile(const PacketView& packet) noexcept {
  const Header& header = packet.header;
  const std::size_t width = header.image_width;
  const std::size_t first = header.first_row * width + header.first_column;
  const std::size_t bytes = header.pixel_count * raw_pixel_bytes(header.codec);
  const bool scalable = header.stream == Stream::kDepth || header.stream == Stream::kWidth;
  return pixel_bytes(header.stream, header.codec) > 0 && header.pixel_count > 0 &&
         (scalable || scale_of(header) == 0) &&
         (header.stream == Stream::kSource || !is_xor_delta(header)) &&
         header.first_column < width && first + header.pixel_count <= width * header.image_height &&
         (bytes == 0 || packet.payload.size() == bytes);
}

}  // namespace stof::wire
