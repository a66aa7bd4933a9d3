// Made by scripts/wire_table.py of firmware/wire/messages.json: change that.
#include "firmware/wire/messages/subscribed.h"

#include <algorithm>

#include "firmware/wire/bytes.h"

namespace stof::wire {

void encode_subscribed(const Subscribed& value,
                       std::span<std::byte, kSubscribedBytes> out) noexcept {
  put_u32(out.subspan<0, 4>(), value.request_id);
  put_u8(out.subspan<4, 1>(), static_cast<std::uint8_t>(value.result));
  put_u8(out.subspan<5, 1>(), value.subscribers);
  put_u16(out.subspan<6, 2>(), value.lease_ms);
  put_u64(out.subspan<8, 8>(), value.cookie);
}

Result<Subscribed> decode_subscribed(std::span<const std::byte> payload) noexcept {
  if (payload.size() < kSubscribedBytes) {
    return fail(Status::kCorrupt);
  }
  const std::span<const std::byte, kSubscribedBytes> in = payload.first<kSubscribedBytes>();
  Subscribed value;
  value.request_id = get_u32(in.subspan<0, 4>());
  value.result = SubscribeResult{get_u8(in.subspan<4, 1>())};
  value.subscribers = get_u8(in.subspan<5, 1>());
  value.lease_ms = get_u16(in.subspan<6, 2>());
  value.cookie = get_u64(in.subspan<8, 8>());
  return value;
}

}  // namespace stof::wire
