// Made by scripts/wire_table.py of firmware/wire/messages.json: change that.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

#include "firmware/wire/messages/enums.h"

namespace stof::wire {

inline constexpr std::size_t kOriginBytes = 8;

struct Origin {
  std::uint32_t device_id = 0;  // of the sensor; in requests the one that is meant, 0: any
  std::uint32_t session_id =
      0;  // random, another one at each start of the sender; in requests ignored
};

void put_origin(std::span<std::byte, kOriginBytes> out, const Origin& value) noexcept;
Origin get_origin(std::span<const std::byte, kOriginBytes> in) noexcept;

inline constexpr std::size_t kLoopCountersBytes = 48;

struct LoopCounters {
  std::uint64_t edges = 0;  // trigger edges since the sender's start, as all counters that follow
  std::uint64_t frames_published = 0;  // frames published
  std::uint64_t mispaired = 0;         // exposures that did not belong to one edge, not published
  std::uint64_t timeouts = 0;          // of cameras
  std::uint64_t deadline_misses = 0;   // periods skipped and frames too old to publish
  std::uint64_t link_drops = 0;        // datagrams that the link did not take
};

void put_loop_counters(std::span<std::byte, kLoopCountersBytes> out,
                       const LoopCounters& value) noexcept;
LoopCounters get_loop_counters(std::span<const std::byte, kLoopCountersBytes> in) noexcept;

inline constexpr std::size_t kDriftReadingBytes = 8;

struct DriftReading {
  std::int32_t value = 0;           // see "Drift" for the unit
  std::int32_t sigma = 2147483647;  // standard deviation; 2^31 - 1: unknown
};

void put_drift_reading(std::span<std::byte, kDriftReadingBytes> out,
                       const DriftReading& value) noexcept;
DriftReading get_drift_reading(std::span<const std::byte, kDriftReadingBytes> in) noexcept;

inline constexpr std::size_t kControlCountersBytes = 104;

struct ControlCounters {
  std::uint64_t accepted =
      0;  // requests that were served, since the sender's start, as all that follow
  std::uint64_t truncated = 0;    // refused: cut short
  std::uint64_t bad_magic = 0;    // refused: not a packet of ours
  std::uint64_t bad_version = 0;  // refused: of another version
  std::uint64_t bad_length = 0;   // refused: longer than it says
  std::uint64_t bad_crc = 0;      // refused: damaged
  std::uint64_t bad_field = 0;    // refused: contradicts itself
  std::uint64_t not_control = 0;  // refused: of a type that a sensor does not take
  std::uint64_t foreign = 0;      // refused: for another device
  std::uint64_t too_short =
      0;  // refused: shorter than its answer could be, from a source that was not validated
  std::uint64_t cookies = 0;  // answered with a cookie only: the source was not validated
  std::uint64_t busy = 0;     // refused: more requests at once than the sensor queues
  std::uint64_t overrun = 0;  // lost before they were read: the socket's buffer was full
};

void put_control_counters(std::span<std::byte, kControlCountersBytes> out,
                          const ControlCounters& value) noexcept;
ControlCounters get_control_counters(std::span<const std::byte, kControlCountersBytes> in) noexcept;

}  // namespace stof::wire
