// Made by scripts/wire_table.py of firmware/wire/messages.json: change that.
#include "firmware/wire/messages/health.h"

#include <algorithm>

#include "firmware/wire/bytes.h"

namespace stof::wire {

void encode_health_report(const HealthReport& value,
                          std::span<std::byte, kHealthReportBytes> out) noexcept {
  put_u64(out.subspan<0, 8>(), value.uptime_ms);
  put_u32(out.subspan<8, 4>(), value.active);
  put_u8(out.subspan<12, 1>(), static_cast<std::uint8_t>(value.severity));
  put_u8(out.subspan<13, 1>(), static_cast<std::uint8_t>(value.reaction));
  put_u8(out.subspan<14, 1>(), value.subscribers);
  std::ranges::fill(out.subspan<15, 1>(), std::byte{0});
  put_u32(out.subspan<16, 4>(), value.rate_mhz);
  put_u32(out.subspan<20, 4>(), value.latency_us);
  put_u32(out.subspan<24, 4>(), value.longest_latency_us);
  put_u32(out.subspan<28, 4>(), value.settings_revision);
  put_loop_counters(out.subspan<32, 48>(), value.counters);
  put_u64(out.subspan<80, 8>(), value.packets_sent);
  put_control_counters(out.subspan<88, 104>(), value.control);
  put_u64(out.subspan<192, 8>(), value.serial_sent);
  put_u64(out.subspan<200, 8>(), value.serial_dropped);
  put_u64(out.subspan<208, 8>(), value.serial_refused);
}

Result<HealthReport> decode_health_report(std::span<const std::byte> payload) noexcept {
  if (payload.size() < kHealthReportBytes) {
    return fail(Status::kCorrupt);
  }
  const std::span<const std::byte, kHealthReportBytes> in = payload.first<kHealthReportBytes>();
  HealthReport value;
  value.uptime_ms = get_u64(in.subspan<0, 8>());
  value.active = get_u32(in.subspan<8, 4>());
  value.severity = Severity{get_u8(in.subspan<12, 1>())};
  value.reaction = Reaction{get_u8(in.subspan<13, 1>())};
  value.subscribers = get_u8(in.subspan<14, 1>());
  value.rate_mhz = get_u32(in.subspan<16, 4>());
  value.latency_us = get_u32(in.subspan<20, 4>());
  value.longest_latency_us = get_u32(in.subspan<24, 4>());
  value.settings_revision = get_u32(in.subspan<28, 4>());
  value.counters = get_loop_counters(in.subspan<32, 48>());
  value.packets_sent = get_u64(in.subspan<80, 8>());
  value.control = get_control_counters(in.subspan<88, 104>());
  value.serial_sent = get_u64(in.subspan<192, 8>());
  value.serial_dropped = get_u64(in.subspan<200, 8>());
  value.serial_refused = get_u64(in.subspan<208, 8>());
  return value;
}

}  // namespace stof::wire
