#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

#include "hal/datagram_port.h"
#include "hal/time.h"

namespace stof::firmware {

using CookieSecret = std::array<std::byte, 16>;  // random, another one at each start

// SipHash-2-4 (Aumasson, Bernstein: "SipHash: a fast short-input PRF", 2012) of `message`.
std::uint64_t siphash24(const CookieSecret& key, std::span<const std::byte> message) noexcept;

// Proof that whoever shows it receives what is sent to its address: nobody can be made a target by
// requests in its name. Nothing is stored for it. A cookie is of one address, port and interface
// and of a time slot.
class Cookies {
 public:
  static constexpr hal::Duration kSlot = std::chrono::seconds(16);

  explicit Cookies(const CookieSecret& secret) noexcept : secret_(secret) {}

  // Never 0.
  std::uint64_t make(const hal::Peer& peer, hal::Time now) const noexcept;
  // A cookie is valid in its slot and the next one: 16 s at least, 32 s at most.
  bool valid(std::uint64_t cookie, const hal::Peer& peer, hal::Time now) const noexcept;

 private:
  std::uint64_t of_slot(const hal::Peer& peer, std::uint64_t slot) const noexcept;

  CookieSecret secret_;
};

}  // namespace stof::firmware
