#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "posix/udp_socket.h"

namespace stof::hal::linux {

// Sockets that only send, all from the port of one socket that receives. Each has a buffer of its
// own: what the system keeps for a peer whose address does not resolve (unres_qlen_bytes of Linux:
// up to 208 KiB for 3 s) leaves the others theirs.
class StreamSockets {
 public:
  // As many as asked, with the same options and address as `receiver`, which is bound and gets
  // every datagram as before; none where the system cannot say who receives (Linux before 4.5,
  // qemu-user), or has no sockets left.
  static StreamSockets open(const posix::UdpSocket& receiver, int family, std::size_t count,
                            std::span<const posix::SocketOption> options, int buffer_bytes);

  bool empty() const noexcept { return sockets_.empty(); }
  std::span<const posix::UdpSocket> all() const noexcept { return sockets_; }

 private:
  std::vector<posix::UdpSocket> sockets_;
};

}  // namespace stof::hal::linux
