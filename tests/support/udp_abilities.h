#pragma once

#include <array>
#include <cstring>

#include <netinet/in.h>
#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>

// What not every system does for UDP sockets; qemu-user leaves some of it out.
namespace stof::test {

inline bool takes_option(int level, int name) {
  const int probe = socket(AF_INET, SOCK_DGRAM | SOCK_CLOEXEC, 0);
  const int on = 1;
  const bool taken = setsockopt(probe, level, name, &on, sizeof on) == 0;
  close(probe);
  return taken;
}

inline bool counts_overruns() { return takes_option(SOL_SOCKET, SO_RXQ_OVFL); }

// Whether an answer "nobody listens there" comes back through the error queue: it is tried.
inline bool tells_refusals() {
  const int probe = socket(AF_INET, SOCK_DGRAM | SOCK_CLOEXEC, 0);
  const int on = 1;
  sockaddr_in to{};
  to.sin_family = AF_INET;
  to.sin_port = htons(1);  // tcpmux: nobody speaks it over UDP
  to.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  sockaddr generic{};
  static_assert(sizeof generic == sizeof to);
  std::memcpy(&generic, &to, sizeof to);
  bool told = setsockopt(probe, IPPROTO_IP, IP_RECVERR, &on, sizeof on) == 0 &&
              sendto(probe, "?", 1, 0, &generic, sizeof generic) == 1;
  pollfd waiting{.fd = probe, .events = 0, .revents = 0};
  told = told && poll(&waiting, 1, 200) == 1;
  alignas(cmsghdr) std::array<char, 512> control{};
  msghdr message{};
  message.msg_control = control.data();
  message.msg_controllen = control.size();
  told = told && recvmsg(probe, &message, MSG_ERRQUEUE) >= 0;
  const cmsghdr* const header = told ? CMSG_FIRSTHDR(&message) : nullptr;
  told = header != nullptr && header->cmsg_level == IPPROTO_IP && header->cmsg_type == IP_RECVERR;
  close(probe);
  return told;
}

}  // namespace stof::test
