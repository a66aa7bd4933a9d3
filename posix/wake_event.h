#pragma once

#include <chrono>

#include "posix/fd.h"

namespace stof::posix {

// Wakes a thread from others (eventfd).
class WakeEvent {
 public:
  WakeEvent() noexcept;

  bool works() const noexcept { return fd_.is_open(); }
  // For any thread.
  void wake() const noexcept;
  // Until somebody woke it since the last time, true, or the time is over.
  bool wait(std::chrono::nanoseconds timeout) const noexcept;

 private:
  Fd fd_;
};

}  // namespace stof::posix
