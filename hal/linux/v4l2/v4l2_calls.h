#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>

#include <poll.h>

#include "hal/time.h"

namespace stof::hal::linux {

// The system calls of V4L2 cameras; tests put a driver of their own here. As the calls of these
// names: one that fails leaves its reason in errno.
class V4l2Calls {
 public:
  virtual ~V4l2Calls() = default;
  // For reading and writing, non-blocking, closed on exec. Negative: not opened.
  virtual int open(const char* path) noexcept = 0;
  virtual void close(int fd) noexcept = 0;
  // Negative: refused.
  virtual int ioctl(int fd, unsigned long request, void* argument) noexcept = 0;
  // A driver's buffer, to be read only. nullptr: not mapped.
  virtual const std::uint8_t* map(int fd, std::size_t bytes, std::uint32_t offset) noexcept = 0;
  virtual void unmap(const std::uint8_t* data, std::size_t bytes) noexcept = 0;
  // How many entries have something to tell, at the latest after `timeout`.
  virtual int poll(std::span<pollfd> entries, Duration timeout) noexcept = 0;
};

V4l2Calls& kernel_calls() noexcept;

// calls.ioctl(), again while a signal interrupts it. Zero, or the error.
int ask_driver(V4l2Calls& calls, int fd, unsigned long request, void* argument) noexcept;

// "what: the error's text; what to do about it".
std::string with_advice(const char* what, int error);

}  // namespace stof::hal::linux
