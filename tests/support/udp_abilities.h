#pragma once

#include <netinet/in.h>
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
inline bool tells_refusals() { return takes_option(IPPROTO_IP, IP_RECVERR); }

}  // namespace stof::test
