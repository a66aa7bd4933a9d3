#pragma once

#include <expected>
#include <optional>
#include <string_view>

#include "hal/datagram_port.h"
#include "hal/linux/open_error.h"
#include "posix/socket_address.h"

namespace stof::hal::linux {

// "HOST:PORT", HOST numeric or a name, an IPv6 address in brackets: "[::1]:5600",
// "[fe80::1%eth0]:5600". The first address of a name counts. Start-up only: may block on a name
// server, and allocates.
std::expected<Peer, OpenError> resolve(std::string_view destination);

// The system's form of a peer for a socket of `family`: AF_INET6 takes every peer, AF_INET only
// IPv4 ones (none otherwise).
std::optional<posix::SocketAddress> to_socket_address(const Peer& peer, int family) noexcept;
// None: neither IPv4 nor IPv6.
std::optional<Peer> to_peer(const posix::SocketAddress& address) noexcept;

// Of all hosts of one of this machine's networks: the system refuses to send there.
bool is_broadcast(const Peer& peer) noexcept;

}  // namespace stof::hal::linux
