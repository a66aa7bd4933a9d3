// Made by scripts/wire_table.py of firmware/wire/messages.json: change that.
#include "firmware/wire/messages/subscribe.h"

#include <algorithm>

#include "firmware/wire/bytes.h"

namespace stof::wire {

void encode_subscribe(const Subscribe& value, std::span<std::byte, kSubscribeBytes> out) noexcept {
  put_u32(out.subspan<0, 4>(), value.request_id);
  put_u16(out.subspan<4, 2>(), value.lease_ms);
  std::ranges::fill(out.subspan<6, 2>(), std::byte{0});
  put_u64(out.subspan<8, 8>(), value.cookie);
  std::ranges::fill(out.subspan<16, 16>(), std::byte{0});
}

Result<Subscribe> decode_subscribe(std::span<const std::byte> payload) noexcept {
  if (payload.size() < kSubscribeBytes) {
    return fail(Status::kCorrupt);
  }
  const std::span<const std::byte, kSubscribeBytes> in = payload.first<kSubscribeBytes>();
  Subscribe value;
  value.request_id = get_u32(in.subspan<0, 4>());
  value.lease_ms = get_u16(in.subspan<4, 2>());
  value.cookie = get_u64(in.subspan<8, 8>());
  return value;
}

}  // namespace stof::wire
