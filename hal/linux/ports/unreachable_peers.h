#pragma once

#include <array>
#include <cstddef>

#include "hal/datagram_port.h"

namespace stof::hal::linux {

// Peers that answered "nobody listens here" (ICMP), from a UDP socket's queue of errors
// (IP_RECVERR, IPV6_RECVERR). For one thread.
class UnreachablePeers {
 public:
  // Empties the queue, as far as it has come. Up to kMost different peers wait; more are forgotten.
  void read(int fd) noexcept;
  // One of them; false: none.
  bool take(Peer& peer) noexcept;

 private:
  static constexpr std::size_t kMost = 16;

  std::array<Peer, kMost> peers_{};
  std::size_t count_ = 0;
};

}  // namespace stof::hal::linux
