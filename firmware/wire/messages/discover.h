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

inline constexpr std::size_t kDiscoverBytes = 128;

// Type 134, to the sensor, also by broadcast.
struct Discover {
  std::uint32_t request_id = 0;  // any number but 0, comes back in the answer
};

void encode_discover(const Discover& value, std::span<std::byte, kDiscoverBytes> out) noexcept;
// kCorrupt: shorter than kDiscoverBytes. What follows is of a newer sender and ignored.
Result<Discover> decode_discover(std::span<const std::byte> payload) noexcept;

}  // namespace stof::wire
