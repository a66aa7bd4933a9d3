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

inline constexpr std::size_t kSubscribedBytes = 16;

// Type 129.
struct Subscribed {
  std::uint32_t request_id = 0;                // of the request
  SubscribeResult result = SubscribeResult{};  // see below
  std::uint8_t subscribers = 0;                // now
  std::uint16_t lease_ms = 0;  // granted; ask again before it is over, best after a third of it
  std::uint64_t cookie = 0;    // for the next request
};

void encode_subscribed(const Subscribed& value,
                       std::span<std::byte, kSubscribedBytes> out) noexcept;
// kCorrupt: shorter than kSubscribedBytes. What follows is of a newer sender and ignored.
Result<Subscribed> decode_subscribed(std::span<const std::byte> payload) noexcept;

}  // namespace stof::wire
