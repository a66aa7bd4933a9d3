#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

#include "firmware/control/cookie.h"
#include "firmware/control/token_bucket.h"
#include "hal/datagram_port.h"
#include "hal/time.h"

namespace stof::firmware {

// What one host is known by, whatever its ports: its IPv4 address, its IPv6 network of 64 bits, of
// which a host has all addresses, or its link-local address.
hal::Peer host_of(const hal::Peer& peer) noexcept;

// So many requests a second of each host: one that floods takes nothing of the others. A table of
// fixed size; hosts of one place in it share their tokens, and a secret says who has which place.
class SourceLimiter {
 public:
  SourceLimiter(const CookieSecret& secret, std::uint32_t per_second) noexcept;

  // Whether one more of that host may pass at `now`, which must not go back.
  bool take(const hal::Peer& from, hal::Time now) noexcept;

 private:
  static constexpr std::size_t kPlaces = 256;

  CookieSecret secret_;
  std::array<TokenBucket, kPlaces> buckets_;
};

}  // namespace stof::firmware
