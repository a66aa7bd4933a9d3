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
// which a host may have all addresses, or its link-local address.
hal::Peer host_of(const hal::Peer& peer) noexcept;

// So many requests a second of each address, whatever its ports: one that floods takes nothing of
// the others. An IPv6 network of 64 bits, which may be one host or all hosts of a link, has what
// kAddressesOfNetwork addresses have. Tables of fixed size; addresses of one place in them share
// their tokens, and a secret says who has which place.
class SourceLimiter {
 public:
  static constexpr std::uint32_t kAddressesOfNetwork = 4;

  SourceLimiter(const CookieSecret& secret, std::uint32_t per_second) noexcept;

  // Whether one more of that address may pass at `now`, which must not go back.
  bool take(const hal::Peer& from, hal::Time now) noexcept;

 private:
  static constexpr std::size_t kAddresses = 256;
  static constexpr std::size_t kNetworks = 32;
  std::uint64_t number_of(const hal::Peer& peer) const noexcept;

  CookieSecret secret_;
  TokenRate of_address_;
  TokenRate of_network_;
  std::array<hal::Time, kAddresses> addresses_;  // when each bucket is full again
  std::array<hal::Time, kNetworks> networks_;
};

}  // namespace stof::firmware
