// Made by scripts/wire_table.py of firmware/wire/messages.json: change that.
#include "firmware/wire/messages/event.h"

#include <algorithm>

#include "firmware/wire/bytes.h"

namespace stof::wire {

void encode_event_report(const EventReport& value,
                         std::span<std::byte, kEventReportBytes> out) noexcept {
  put_u32(out.subspan<0, 4>(), value.sequence);
  put_u8(out.subspan<4, 1>(), value.condition);
  put_u8(out.subspan<5, 1>(), static_cast<std::uint8_t>(value.severity));
  put_u8(out.subspan<6, 1>(), static_cast<std::uint8_t>(value.reaction));
  put_u8(out.subspan<7, 1>(), value.active);
  put_u32(out.subspan<8, 4>(), value.count);
  put_u32(out.subspan<12, 4>(), value.value);
  put_i64(out.subspan<16, 8>(), value.at_ns);
}

Result<EventReport> decode_event_report(std::span<const std::byte> payload) noexcept {
  if (payload.size() < kEventReportBytes) {
    return fail(Status::kCorrupt);
  }
  const std::span<const std::byte, kEventReportBytes> in = payload.first<kEventReportBytes>();
  EventReport value;
  value.sequence = get_u32(in.subspan<0, 4>());
  value.condition = get_u8(in.subspan<4, 1>());
  value.severity = Severity{get_u8(in.subspan<5, 1>())};
  value.reaction = Reaction{get_u8(in.subspan<6, 1>())};
  value.active = get_u8(in.subspan<7, 1>());
  value.count = get_u32(in.subspan<8, 4>());
  value.value = get_u32(in.subspan<12, 4>());
  value.at_ns = get_i64(in.subspan<16, 8>());
  return value;
}

}  // namespace stof::wire
