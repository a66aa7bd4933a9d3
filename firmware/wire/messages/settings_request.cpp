// Made by scripts/wire_table.py of firmware/wire/messages.json: change that.
#include "firmware/wire/messages/settings_request.h"

#include <algorithm>

#include "firmware/wire/bytes.h"

namespace stof::wire {

void encode_settings_request(const SettingsRequest& value,
                             std::span<std::byte, kSettingsRequestBytes> out) noexcept {
  put_u32(out.subspan<0, 4>(), value.request_id);
  put_u8(out.subspan<4, 1>(), static_cast<std::uint8_t>(value.operation));
  put_u8(out.subspan<5, 1>(), static_cast<std::uint8_t>(value.document));
  put_u16(out.subspan<6, 2>(), value.offset);
  put_u64(out.subspan<8, 8>(), value.cookie);
  std::ranges::fill(out.subspan<16, 8>(), std::byte{0});
}

Result<SettingsRequest> decode_settings_request(std::span<const std::byte> payload) noexcept {
  if (payload.size() < kSettingsRequestBytes) {
    return fail(Status::kCorrupt);
  }
  const std::span<const std::byte, kSettingsRequestBytes> in =
      payload.first<kSettingsRequestBytes>();
  SettingsRequest value;
  value.request_id = get_u32(in.subspan<0, 4>());
  value.operation = SettingsOperation{get_u8(in.subspan<4, 1>())};
  value.document = SettingsDocument{get_u8(in.subspan<5, 1>())};
  value.offset = get_u16(in.subspan<6, 2>());
  value.cookie = get_u64(in.subspan<8, 8>());
  return value;
}

}  // namespace stof::wire
