#pragma once

#include <cstring>
#include <functional>

#include <net/if.h>
#include <sched.h>
#include <sys/ioctl.h>
#include <sys/socket.h>
#include <sys/wait.h>
#include <unistd.h>

#include "posix/fd.h"

namespace stof::test {

inline constexpr int kSkipped = 77;

// Runs it in a child with a network of its own, which is a loopback interface alone: what it does
// to the system's routes stays there. Returns what it returned, 0 to 255. Needs to be root;
// kSkipped where it may not.
inline int in_own_network(const std::function<int()>& body) {
  const pid_t child = fork();
  if (child == 0) {
    ifreq loopback{};
    std::strncpy(loopback.ifr_name, "lo", IFNAMSIZ - 1);
    loopback.ifr_flags = IFF_UP | IFF_RUNNING;
    const posix::Fd any(unshare(CLONE_NEWNET) == 0 ? socket(AF_INET, SOCK_DGRAM, 0) : -1);
    const bool up = any.is_open() && ioctl(any.get(), SIOCSIFFLAGS, &loopback) == 0;
    _exit(up ? body() : kSkipped);
  }
  int status = 0;
  waitpid(child, &status, 0);
  return WIFEXITED(status) ? WEXITSTATUS(status) : -1;
}

}  // namespace stof::test
