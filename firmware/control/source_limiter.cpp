#include "firmware/control/source_limiter.h"

#include <algorithm>
#include <span>

namespace stof::firmware {
namespace {

constexpr std::size_t kNetworkBytes = 8;  // of an IPv6 address

bool is_ipv4(const hal::Peer& peer) noexcept {
  constexpr std::array<std::uint8_t, 12> kMapped{0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0xFF, 0xFF};
  return std::ranges::equal(std::span(peer.address).first<kMapped.size()>(), kMapped);
}

bool is_link_local(const hal::Peer& peer) noexcept {
  return peer.address[0] == 0xFE && (peer.address[1] & 0xC0U) == 0x80;
}

// Whether its network of 64 bits is one host.
bool has_network(const hal::Peer& peer) noexcept { return !is_ipv4(peer) && !is_link_local(peer); }

}  // namespace

hal::Peer host_of(const hal::Peer& peer) noexcept {
  hal::Peer host{.address = peer.address, .scope = peer.scope};
  if (has_network(peer)) {
    std::ranges::fill(std::span(host.address).subspan<kNetworkBytes>(), std::uint8_t{0});
  }
  return host;
}

SourceLimiter::SourceLimiter(const CookieSecret& secret, std::uint32_t per_second) noexcept
    : secret_(secret), of_address_(per_second), of_network_(kAddressesOfNetwork * per_second) {
  addresses_.fill(TokenRate::kFull);
  networks_.fill(TokenRate::kFull);
}

std::uint64_t SourceLimiter::number_of(const hal::Peer& peer) const noexcept {
  return siphash24(secret_, std::as_bytes(std::span(peer.address)));
}

bool SourceLimiter::take(const hal::Peer& from, hal::Time now) noexcept {
  // The address first: what it is refused takes nothing of what its network shares.
  return of_address_.take(addresses_[number_of(from) % kAddresses], now) &&
         (!has_network(from) ||
          of_network_.take(networks_[number_of(host_of(from)) % kNetworks], now));
}

}  // namespace stof::firmware
