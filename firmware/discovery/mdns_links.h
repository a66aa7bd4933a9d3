#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>

#include "firmware/discovery/mdns_records.h"
#include "hal/datagram_port.h"
#include "hal/network_interfaces.h"
#include "hal/time.h"

namespace stof::firmware {

// One interface by one kind of address, and what is still to be answered there.
struct MdnsLink {
  std::uint32_t interface = 0;
  bool ipv6 = false;
  RecordSet pending = 0;
  hal::Time due{};
  std::optional<hal::Peer> more_from{};  // who will tell what it knows of the pending answers
  std::array<std::optional<hal::Time>, kRecordKinds> sent{};
};

// The addresses of this machine, and the links that they make.
class MdnsLinks {
 public:
  static constexpr std::size_t kMostAddresses = 32;
  static constexpr std::size_t kMostLinks = 16;

  // Those beyond kMostAddresses are left out, and interfaces without multicast have no link. The
  // links are new: nothing is pending.
  void set_addresses(std::span<const hal::InterfaceAddress> addresses) noexcept;
  // Whether set_addresses() would find what it knows.
  bool knows(std::span<const hal::InterfaceAddress> addresses) const noexcept;

  std::span<const hal::InterfaceAddress> addresses() const noexcept {
    return std::span(addresses_).first(address_count_);
  }
  std::span<MdnsLink> all() noexcept { return std::span(links_).first(link_count_); }
  // nullptr: the peer's interface has no link of its kind.
  MdnsLink* link_of(const hal::Peer& peer) noexcept;
  // Whether the peer is in the same network (RFC 6762 section 11). It also keeps this from being an
  // amplifier of the wide network.
  bool reaches(const hal::Peer& peer) const noexcept;

 private:
  void find_links() noexcept;

  std::array<hal::InterfaceAddress, kMostAddresses> addresses_{};
  std::size_t address_count_ = 0;
  std::array<MdnsLink, kMostLinks> links_{};
  std::size_t link_count_ = 0;
};

}  // namespace stof::firmware
