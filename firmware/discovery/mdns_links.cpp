#include "firmware/discovery/mdns_links.h"

#include <algorithm>

namespace stof::firmware {
namespace {

// Whether the first `bits` are alike.
bool same_prefix(const std::array<std::uint8_t, 16>& a, const std::array<std::uint8_t, 16>& b,
                 unsigned bits) noexcept {
  for (unsigned i = 0; i < 16 && 8 * i < bits; ++i) {
    const unsigned rest = std::min(8U, bits - 8 * i);
    if (((a[i] ^ b[i]) >> (8 - rest)) != 0) {
      return false;
    }
  }
  return true;
}

}  // namespace

void MdnsLinks::find_links() noexcept {
  link_count_ = 0;
  for (const hal::InterfaceAddress& address : addresses()) {
    const bool ipv6 = !hal::is_ipv4(address.address);
    const bool is_known = std::ranges::any_of(all(), [&](const MdnsLink& link) {
      return link.interface == address.interface && link.ipv6 == ipv6;
    });
    if (address.multicast && !is_known && link_count_ < kMostLinks) {
      links_[link_count_++] = MdnsLink{.interface = address.interface, .ipv6 = ipv6};
    }
  }
}

void MdnsLinks::set_addresses(std::span<const hal::InterfaceAddress> addresses) noexcept {
  address_count_ = std::min(addresses.size(), kMostAddresses);
  std::ranges::copy(addresses.first(address_count_), addresses_.begin());
  find_links();
}

bool MdnsLinks::knows(std::span<const hal::InterfaceAddress> addresses) const noexcept {
  return std::ranges::equal(addresses.first(std::min(addresses.size(), kMostAddresses)),
                            this->addresses());
}

MdnsLink* MdnsLinks::link_of(const hal::Peer& peer) noexcept {
  const bool ipv6 = !hal::is_ipv4(peer.address);
  const auto found = std::ranges::find_if(all(), [&](const MdnsLink& link) {
    return link.interface == peer.scope && link.ipv6 == ipv6;
  });
  return found == all().end() ? nullptr : &*found;
}

bool MdnsLinks::reaches(const hal::Peer& peer) const noexcept {
  return std::ranges::any_of(addresses(), [&](const hal::InterfaceAddress& own) {
    return own.interface == peer.scope && same_prefix(own.address, peer.address, own.prefix_bits);
  });
}

}  // namespace stof::firmware
