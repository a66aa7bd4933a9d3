// Made by scripts/wire_table.py of firmware/wire/messages.json: change that.
#include "firmware/wire/messages/structs.h"

#include <algorithm>

#include "firmware/wire/bytes.h"

namespace stof::wire {

void put_origin(std::span<std::byte, kOriginBytes> out, const Origin& value) noexcept {
  put_u32(out.subspan<0, 4>(), value.device_id);
  put_u32(out.subspan<4, 4>(), value.session_id);
}

Origin get_origin(std::span<const std::byte, kOriginBytes> in) noexcept {
  Origin value;
  value.device_id = get_u32(in.subspan<0, 4>());
  value.session_id = get_u32(in.subspan<4, 4>());
  return value;
}

void put_loop_counters(std::span<std::byte, kLoopCountersBytes> out,
                       const LoopCounters& value) noexcept {
  put_u64(out.subspan<0, 8>(), value.edges);
  put_u64(out.subspan<8, 8>(), value.frames_published);
  put_u64(out.subspan<16, 8>(), value.mispaired);
  put_u64(out.subspan<24, 8>(), value.timeouts);
  put_u64(out.subspan<32, 8>(), value.deadline_misses);
  put_u64(out.subspan<40, 8>(), value.link_drops);
}

LoopCounters get_loop_counters(std::span<const std::byte, kLoopCountersBytes> in) noexcept {
  LoopCounters value;
  value.edges = get_u64(in.subspan<0, 8>());
  value.frames_published = get_u64(in.subspan<8, 8>());
  value.mispaired = get_u64(in.subspan<16, 8>());
  value.timeouts = get_u64(in.subspan<24, 8>());
  value.deadline_misses = get_u64(in.subspan<32, 8>());
  value.link_drops = get_u64(in.subspan<40, 8>());
  return value;
}

void put_drift_reading(std::span<std::byte, kDriftReadingBytes> out,
                       const DriftReading& value) noexcept {
  put_i32(out.subspan<0, 4>(), value.value);
  put_i32(out.subspan<4, 4>(), value.sigma);
}

DriftReading get_drift_reading(std::span<const std::byte, kDriftReadingBytes> in) noexcept {
  DriftReading value;
  value.value = get_i32(in.subspan<0, 4>());
  value.sigma = get_i32(in.subspan<4, 4>());
  return value;
}

void put_control_counters(std::span<std::byte, kControlCountersBytes> out,
                          const ControlCounters& value) noexcept {
  put_u64(out.subspan<0, 8>(), value.accepted);
  put_u64(out.subspan<8, 8>(), value.truncated);
  put_u64(out.subspan<16, 8>(), value.bad_magic);
  put_u64(out.subspan<24, 8>(), value.bad_version);
  put_u64(out.subspan<32, 8>(), value.bad_length);
  put_u64(out.subspan<40, 8>(), value.bad_crc);
  put_u64(out.subspan<48, 8>(), value.bad_field);
  put_u64(out.subspan<56, 8>(), value.not_control);
  put_u64(out.subspan<64, 8>(), value.foreign);
  put_u64(out.subspan<72, 8>(), value.too_short);
  put_u64(out.subspan<80, 8>(), value.cookies);
  put_u64(out.subspan<88, 8>(), value.busy);
  put_u64(out.subspan<96, 8>(), value.overrun);
}

ControlCounters get_control_counters(
    std::span<const std::byte, kControlCountersBytes> in) noexcept {
  ControlCounters value;
  value.accepted = get_u64(in.subspan<0, 8>());
  value.truncated = get_u64(in.subspan<8, 8>());
  value.bad_magic = get_u64(in.subspan<16, 8>());
  value.bad_version = get_u64(in.subspan<24, 8>());
  value.bad_length = get_u64(in.subspan<32, 8>());
  value.bad_crc = get_u64(in.subspan<40, 8>());
  value.bad_field = get_u64(in.subspan<48, 8>());
  value.not_control = get_u64(in.subspan<56, 8>());
  value.foreign = get_u64(in.subspan<64, 8>());
  value.too_short = get_u64(in.subspan<72, 8>());
  value.cookies = get_u64(in.subspan<80, 8>());
  value.busy = get_u64(in.subspan<88, 8>());
  value.overrun = get_u64(in.subspan<96, 8>());
  return value;
}

}  // namespace stof::wire
