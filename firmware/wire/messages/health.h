// Made by scripts/wire_table.py of firmware/wire/messages.json: change that.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

#include "dsp/base/status.h"
#include "firmware/wire/messages/enums.h"
#include "firmware/wire/messages/structs.h"

namespace stof::wire {

inline constexpr std::size_t kHealthReportBytes = 216;

// Type 65, once a second and on change, also while there are no frames.
struct HealthReport {
  std::uint64_t uptime_ms = 0;     // since the sender's start, ms
  std::uint32_t active = 0;        // bit k: condition k of "Events" is active
  Severity severity = Severity{};  // the highest of them
  Reaction reaction = Reaction{};  // what the robot should do
  std::uint8_t subscribers = 0;    // that the streams go to now
  std::uint32_t rate_mhz = 0;      // frames of the last second, 1/1000 Hz
  std::uint32_t latency_us =
      0;  // mean of the last second: exposure middle to the sending of the last packet, us
  std::uint32_t longest_latency_us = 0;  // longest of the last second, us
  std::uint32_t settings_revision = 0;   // as in the frame info
  LoopCounters counters{};               // loop_counters
  std::uint64_t packets_sent = 0;        // datagrams to all subscribers
  ControlCounters control{};             // control_counters
  std::uint64_t serial_sent = 0;         // frames and messages on the serial line
  std::uint64_t serial_dropped = 0;      // of these, not sent: the line was busy
  std::uint64_t serial_refused =
      0;  // frames and messages from the serial line that were damaged or unknown
};

void encode_health_report(const HealthReport& value,
                          std::span<std::byte, kHealthReportBytes> out) noexcept;
// kCorrupt: shorter than kHealthReportBytes. What follows is of a newer sender and ignored.
Result<HealthReport> decode_health_report(std::span<const std::byte> payload) noexcept;

}  // namespace stof::wire
