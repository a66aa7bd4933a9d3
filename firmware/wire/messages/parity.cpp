// Made by scripts/wire_table.py of firmware/wire/messages.json: change that.
#include "firmware/wire/messages/parity.h"

#include <algorithm>

#include "firmware/wire/bytes.h"

namespace stof::wire {

void encode_parity_fields(const ParityFields& value,
                          std::span<std::byte, kParityFieldsBytes> out) noexcept {
  put_u16(out.subspan<0, 2>(), value.count);
  put_u8(out.subspan<2, 1>(), value.type);
  put_u8(out.subspan<3, 1>(), value.flags);
  put_u8(out.subspan<4, 1>(), value.stream);
  put_u8(out.subspan<5, 1>(), value.codec);
  put_u16(out.subspan<6, 2>(), value.image_width);
  put_u16(out.subspan<8, 2>(), value.image_height);
  put_u16(out.subspan<10, 2>(), value.first_row);
  put_u16(out.subspan<12, 2>(), value.first_column);
  put_u16(out.subspan<14, 2>(), value.pixel_count);
  put_u16(out.subspan<16, 2>(), value.payload_length);
}

Result<ParityFields> decode_parity_fields(std::span<const std::byte> payload) noexcept {
  if (payload.size() < kParityFieldsBytes) {
    return fail(Status::kCorrupt);
  }
  const std::span<const std::byte, kParityFieldsBytes> in = payload.first<kParityFieldsBytes>();
  ParityFields value;
  value.count = get_u16(in.subspan<0, 2>());
  value.type = get_u8(in.subspan<2, 1>());
  value.flags = get_u8(in.subspan<3, 1>());
  value.stream = get_u8(in.subspan<4, 1>());
  value.codec = get_u8(in.subspan<5, 1>());
  value.image_width = get_u16(in.subspan<6, 2>());
  value.image_height = get_u16(in.subspan<8, 2>());
  value.first_row = get_u16(in.subspan<10, 2>());
  value.first_column = get_u16(in.subspan<12, 2>());
  value.pixel_count = get_u16(in.subspan<14, 2>());
  value.payload_length = get_u16(in.subspan<16, 2>());
  return value;
}

}  // namespace stof::wire
