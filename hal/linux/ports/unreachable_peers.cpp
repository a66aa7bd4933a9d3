#include "hal/linux/ports/unreachable_peers.h"

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <optional>
#include <span>

#include <linux/errqueue.h>
#include <netinet/in.h>
#include <sys/socket.h>

#include "hal/linux/ports/peer_address.h"

namespace stof::hal::linux {
namespace {

// One answer that came.
struct Told {
  std::optional<Peer> peer;  // where the datagram went that is answered
  bool refused = false;      // nobody listens there
};

// None: the queue is empty.
std::optional<Told> read_one(int fd) noexcept {
  constexpr std::size_t kSpace = 512;
  alignas(cmsghdr) std::array<std::byte, kSpace> control;
  posix::SocketAddress to;
  msghdr message{};
  message.msg_name = &to.storage;
  message.msg_namelen = to.length;
  message.msg_control = control.data();
  message.msg_controllen = control.size();
  if (recvmsg(fd, &message, MSG_ERRQUEUE | MSG_DONTWAIT) < 0) {
    return std::nullopt;
  }
  Told told{.peer = to_peer(to)};
  for (cmsghdr* entry = CMSG_FIRSTHDR(&message); entry != nullptr;
       entry = CMSG_NXTHDR(&message, entry)) {
    if ((entry->cmsg_level == IPPROTO_IP && entry->cmsg_type == IP_RECVERR) ||
        (entry->cmsg_level == IPPROTO_IPV6 && entry->cmsg_type == IPV6_RECVERR)) {
      sock_extended_err error{};
      std::memcpy(&error, CMSG_DATA(entry), sizeof error);
      told.refused = error.ee_errno == ECONNREFUSED;
    }
  }
  return told;
}

}  // namespace

void UnreachablePeers::read(int fd) noexcept {
  constexpr int kAtOnce = 256;  // a peer must not keep us here
  for (int i = 0; i < kAtOnce; ++i) {
    const std::optional<Told> told = read_one(fd);
    if (!told) {
      return;
    }
    const std::span<const Peer> known = std::span(peers_).first(count_);
    if (told->refused && told->peer && count_ < kMost &&
        std::ranges::find(known, *told->peer) == known.end()) {
      peers_[count_++] = *told->peer;
    }
  }
}

bool UnreachablePeers::take(Peer& peer) noexcept {
  if (count_ == 0) {
    return false;
  }
  peer = peers_[--count_];
  return true;
}

}  // namespace stof::hal::linux
