// Made by scripts/wire_table.py of firmware/wire/messages.json: change that.
#include "firmware/wire/messages/announce.h"

#include <algorithm>

#include "firmware/wire/bytes.h"

namespace stof::wire {

void encode_announce(const Announce& value, std::span<std::byte, kAnnounceBytes> out) noexcept {
  put_u32(out.subspan<0, 4>(), value.request_id);
  put_u16(out.subspan<4, 2>(), value.port);
  put_u8(out.subspan<6, 1>(), value.subscribers);
  put_u8(out.subspan<7, 1>(), value.most_subscribers);
  for (std::size_t i = 0; i < 16; ++i) {
    put_u8(out.subspan(8 + 1 * i).first<1>(), static_cast<std::uint8_t>(value.serial[i]));
  }
  for (std::size_t i = 0; i < 32; ++i) {
    put_u8(out.subspan(24 + 1 * i).first<1>(), static_cast<std::uint8_t>(value.name[i]));
  }
  for (std::size_t i = 0; i < 16; ++i) {
    put_u8(out.subspan(56 + 1 * i).first<1>(), static_cast<std::uint8_t>(value.version[i]));
  }
  for (std::size_t i = 0; i < 16; ++i) {
    put_u8(out.subspan(72 + 1 * i).first<1>(), static_cast<std::uint8_t>(value.board[i]));
  }
  put_u64(out.subspan<88, 8>(), value.uptime_ms);
  put_u16(out.subspan<96, 2>(), value.image_width);
  put_u16(out.subspan<98, 2>(), value.image_height);
  put_u32(out.subspan<100, 4>(), value.rate_mhz);
  std::ranges::fill(out.subspan<104, 24>(), std::byte{0});
}

Result<Announce> decode_announce(std::span<const std::byte> payload) noexcept {
  if (payload.size() < kAnnounceBytes) {
    return fail(Status::kCorrupt);
  }
  const std::span<const std::byte, kAnnounceBytes> in = payload.first<kAnnounceBytes>();
  Announce value;
  value.request_id = get_u32(in.subspan<0, 4>());
  value.port = get_u16(in.subspan<4, 2>());
  value.subscribers = get_u8(in.subspan<6, 1>());
  value.most_subscribers = get_u8(in.subspan<7, 1>());
  for (std::size_t i = 0; i < 16; ++i) {
    value.serial[i] = static_cast<char>(get_u8(in.subspan(8 + 1 * i).first<1>()));
  }
  for (std::size_t i = 0; i < 32; ++i) {
    value.name[i] = static_cast<char>(get_u8(in.subspan(24 + 1 * i).first<1>()));
  }
  for (std::size_t i = 0; i < 16; ++i) {
    value.version[i] = static_cast<char>(get_u8(in.subspan(56 + 1 * i).first<1>()));
  }
  for (std::size_t i = 0; i < 16; ++i) {
    value.board[i] = static_cast<char>(get_u8(in.subspan(72 + 1 * i).first<1>()));
  }
  value.uptime_ms = get_u64(in.subspan<88, 8>());
  value.image_width = get_u16(in.subspan<96, 2>());
  value.image_height = get_u16(in.subspan<98, 2>());
  value.rate_mhz = get_u32(in.subspan<100, 4>());
  return value;
}

}  // namespace stof::wire
