#include "host/cli/live/enter_wait.h"

#include <array>
#include <cerrno>
#include <chrono>

#include <unistd.h>

#include "posix/poll.h"

namespace stof::host {

Answer wait_for_enter(const std::function<bool()>& stop) {
  constexpr std::chrono::milliseconds kLook{100};
  while (!stop()) {
    std::array<pollfd, 1> entries{pollfd{.fd = STDIN_FILENO, .events = POLLIN, .revents = 0}};
    const std::expected<int, int> ready = posix::wait_for(entries, kLook);
    if (!ready) {
      return Answer::kNobody;
    }
    if (*ready == 0) {
      continue;
    }
    // One byte at a time: what belongs to the next question stays where it is.
    char byte = 0;
    const ssize_t got = ::read(STDIN_FILENO, &byte, 1);
    if (got == 0 || (got < 0 && errno != EINTR && errno != EAGAIN)) {
      return Answer::kNobody;
    }
    if (got == 1 && byte == '\n') {
      return Answer::kEnter;
    }
  }
  return Answer::kStopped;
}

}  // namespace stof::host
