// Made by scripts/wire_table.py of firmware/wire/messages.json: change that.
#include "firmware/wire/messages/discover.h"

#include <algorithm>

#include "firmware/wire/bytes.h"

namespace stof::wire {

void encode_discover(const Discover& value, std::span<std::byte, kDiscoverBytes> out) noexcept {
  put_u32(out.subspan<0, 4>(), value.request_id);
  std::ranges::fill(out.subspan<4, 124>(), std::byte{0});
}

Result<Discover> decode_discover(std::span<const std::byte> payload) noexcept {
  if (payload.size() < kDiscoverBytes) {
    return fail(Status::kCorrupt);
  }
  const std::span<const std::byte, kDiscoverBytes> in = payload.first<kDiscoverBytes>();
  Discover value;
  value.request_id = get_u32(in.subspan<0, 4>());
  return value;
}

}  // namespace stof::wire
