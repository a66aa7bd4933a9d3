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

inline constexpr std::size_t kEventReportBytes = 24;

// Type 67.
struct EventReport {
  std::uint32_t sequence = 0;      // advances with each change; the repetition has the same
  std::uint8_t condition = 0;      // see "Events"
  Severity severity = Severity{};  // of it
  Reaction reaction = Reaction{};  // what the robot should do while it is active
  std::uint8_t active = 0;         // 1: it began, 0: it ended
  std::uint32_t count = 0;         // how often it has begun since the sender's start
  std::uint32_t value = 0;         // depends on the condition
  std::int64_t at_ns = 0;          // when, ns, clock of the header
};

void encode_event_report(const EventReport& value,
                         std::span<std::byte, kEventReportBytes> out) noexcept;
// kCorrupt: shorter than kEventReportBytes. What follows is of a newer sender and ignored.
Result<EventReport> decode_event_report(std::span<const std::byte> payload) noexcept;

}  // namespace stof::wire
