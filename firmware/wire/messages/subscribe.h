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

inline constexpr std::size_t kSubscribeBytes = 32;

// Types 128 and 130, to the sensor.
struct Subscribe {
  std::uint32_t request_id = 0;  // any number, comes back in the answer
  std::uint16_t lease_ms =
      0;  // how long to send without hearing from us; the sensor takes 500 to 10,000, 0: 3,000
  std::uint64_t cookie = 0;  // of an answer; 0: none yet
};

void encode_subscribe(const Subscribe& value, std::span<std::byte, kSubscribeBytes> out) noexcept;
// kCorrupt: shorter than kSubscribeBytes. What follows is of a newer sender and ignored.
Result<Subscribe> decode_subscribe(std::span<const std::byte> payload) noexcept;

}  // namespace stof::wire
