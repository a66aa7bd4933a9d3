#include "posix/wake_event.h"

#include <array>

#include <sys/eventfd.h>

#include "posix/poll.h"

namespace stof::posix {

WakeEvent::WakeEvent() noexcept : fd_(eventfd(0, EFD_NONBLOCK | EFD_CLOEXEC)) {}

void WakeEvent::wake() const noexcept {
  // Fails only where it was woken 2^64 - 2 times and nobody came.
  static_cast<void>(eventfd_write(fd_.get(), 1));
}

bool WakeEvent::wait(std::chrono::nanoseconds timeout) const noexcept {
  const auto deadline = std::chrono::steady_clock::now() + timeout;
  for (;;) {
    eventfd_t woken = 0;
    if (eventfd_read(fd_.get(), &woken) == 0) {
      return true;
    }
    const std::chrono::nanoseconds left = deadline - std::chrono::steady_clock::now();
    if (left <= std::chrono::nanoseconds::zero()) {
      return false;
    }
    std::array entries{pollfd{.fd = fd_.get(), .events = POLLIN, .revents = 0}};
    static_cast<void>(wait_for(entries, left));
  }
}

}  // namespace stof::posix
