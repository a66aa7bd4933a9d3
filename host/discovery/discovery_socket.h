#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>

#include "posix/udp_socket.h"

namespace stof::client {

// A UDP socket of one kind of address that asks who is there: by broadcast and by multicast.
class DiscoverySocket {
 public:
  // port 0: any free one; another one may be shared with other programs. Not open where the system
  // does not give it.
  DiscoverySocket(int family, std::uint16_t port);

  bool is_open() const { return socket_.is_open(); }
  int fd() const { return socket_.fd(); }

  // Drops what cannot be sent, and what goes to another kind of address.
  void send(const posix::SocketAddress& to, std::span<const std::byte> datagram) const;
  // To a multicast group, or all hosts of the link, by one interface.
  void send_by(unsigned interface, const posix::SocketAddress& to,
               std::span<const std::byte> datagram) const;

  struct Read {
    std::span<const std::byte> datagram;  // in `space`
    std::string from;                     // numeric address
  };
  std::optional<Read> receive(std::span<std::byte> space) const;

 private:
  int family_;
  posix::UdpSocket socket_;
};

}  // namespace stof::client
