// Made by scripts/wire_table.py of firmware/wire/messages.json: change that.
#include "firmware/wire/messages/header.h"

#include <algorithm>

#include "firmware/wire/bytes.h"

namespace stof::wire {

void encode_header_fields(const HeaderFields& value,
                          std::span<std::byte, kHeaderFieldsBytes> out) noexcept {
  put_u32(out.subspan<0, 4>(), 0x464f5453);
  put_u8(out.subspan<4, 1>(), 1);
  put_u8(out.subspan<5, 1>(), static_cast<std::uint8_t>(value.type));
  put_u8(out.subspan<6, 1>(), 52);
  put_u8(out.subspan<7, 1>(), value.flags);
  put_origin(out.subspan<8, 8>(), value.origin);
  put_u8(out.subspan<16, 1>(), static_cast<std::uint8_t>(value.stream));
  put_u8(out.subspan<17, 1>(), static_cast<std::uint8_t>(value.codec));
  put_u8(out.subspan<18, 1>(), static_cast<std::uint8_t>(value.health));
  put_u8(out.subspan<19, 1>(), static_cast<std::uint8_t>(value.clock));
  put_u32(out.subspan<20, 4>(), value.number);
  put_i64(out.subspan<24, 8>(), value.exposure_middle_ns);
  put_u32(out.subspan<32, 4>(), value.freshness);
  put_u16(out.subspan<36, 2>(), value.index);
  put_u16(out.subspan<38, 2>(), value.count);
  put_u16(out.subspan<40, 2>(), value.image_width);
  put_u16(out.subspan<42, 2>(), value.image_height);
  put_u16(out.subspan<44, 2>(), value.first_row);
  put_u16(out.subspan<46, 2>(), value.first_column);
  put_u16(out.subspan<48, 2>(), value.pixel_count);
  put_u16(out.subspan<50, 2>(), value.payload_length);
}

Result<HeaderFields> decode_header_fields(std::span<const std::byte> payload) noexcept {
  if (payload.size() < kHeaderFieldsBytes) {
    return fail(Status::kCorrupt);
  }
  const std::span<const std::byte, kHeaderFieldsBytes> in = payload.first<kHeaderFieldsBytes>();
  HeaderFields value;
  value.type = PacketType{get_u8(in.subspan<5, 1>())};
  value.flags = get_u8(in.subspan<7, 1>());
  value.origin = get_origin(in.subspan<8, 8>());
  value.stream = Stream{get_u8(in.subspan<16, 1>())};
  value.codec = Codec{get_u8(in.subspan<17, 1>())};
  value.health = Health{get_u8(in.subspan<18, 1>())};
  value.clock = ClockState{get_u8(in.subspan<19, 1>())};
  value.number = get_u32(in.subspan<20, 4>());
  value.exposure_middle_ns = get_i64(in.subspan<24, 8>());
  value.freshness = get_u32(in.subspan<32, 4>());
  value.index = get_u16(in.subspan<36, 2>());
  value.count = get_u16(in.subspan<38, 2>());
  value.image_width = get_u16(in.subspan<40, 2>());
  value.image_height = get_u16(in.subspan<42, 2>());
  value.first_row = get_u16(in.subspan<44, 2>());
  value.first_column = get_u16(in.subspan<46, 2>());
  value.pixel_count = get_u16(in.subspan<48, 2>());
  value.payload_length = get_u16(in.subspan<50, 2>());
  return value;
}

}  // namespace stof::wire
