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

inline constexpr std::size_t kAnnounceBytes = 128;

// Type 68.
struct Announce {
  std::uint32_t request_id = 0;       // of the discover that it answers; 0 in the beacon
  std::uint16_t port = 0;             // UDP port of the sensor for requests
  std::uint8_t subscribers = 0;       // now
  std::uint8_t most_subscribers = 0;  // that it takes
  std::array<char, 16> serial{};      // serial number, UTF-8, filled up with 0, as all texts
  std::array<char, 32> name{};        // given by whoever owns it
  std::array<char, 16> version{};     // of its software
  std::array<char, 16> board{};       // what it is
  std::uint64_t uptime_ms = 0;        // since its start, ms
  std::uint16_t image_width = 0;      // of its depth, pixels
  std::uint16_t image_height = 0;     // rows
  std::uint32_t rate_mhz = 0;         // frames of the last second, 1/1000 Hz
};

void encode_announce(const Announce& value, std::span<std::byte, kAnnounceBytes> out) noexcept;
// kCorrupt: shorter than kAnnounceBytes. What follows is of a newer sender and ignored.
Result<Announce> decode_announce(std::span<const std::byte> payload) noexcept;

}  // namespace stof::wire
