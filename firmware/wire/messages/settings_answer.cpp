// Made by scripts/wire_table.py of firmware/wire/messages.json: change that.
#include "firmware/wire/messages/settings_answer.h"

#include <algorithm>

#include "firmware/wire/bytes.h"

namespace stof::wire {

void encode_settings_answer(const SettingsAnswer& value,
                            std::span<std::byte, kSettingsAnswerBytes> out) noexcept {
  put_u32(out.subspan<0, 4>(), value.request_id);
  put_u8(out.subspan<4, 1>(), static_cast<std::uint8_t>(value.result));
  put_u8(out.subspan<5, 1>(), value.restart);
  put_u16(out.subspan<6, 2>(), value.total);
  put_u32(out.subspan<8, 4>(), value.revision);
  std::ranges::fill(out.subspan<12, 4>(), std::byte{0});
  put_u64(out.subspan<16, 8>(), value.cookie);
}

Result<SettingsAnswer> decode_settings_answer(std::span<const std::byte> payload) noexcept {
  if (payload.size() < kSettingsAnswerBytes) {
    return fail(Status::kCorrupt);
  }
  const std::span<const std::byte, kSettingsAnswerBytes> in = payload.first<kSettingsAnswerBytes>();
  SettingsAnswer value;
  value.request_id = get_u32(in.subspan<0, 4>());
  value.result = SettingsResult{get_u8(in.subspan<4, 1>())};
  value.restart = get_u8(in.subspan<5, 1>());
  value.total = get_u16(in.subspan<6, 2>());
  value.revision = get_u32(in.subspan<8, 4>());
  value.cookie = get_u64(in.subspan<16, 8>());
  return value;
}

}  // namespace stof::wire
