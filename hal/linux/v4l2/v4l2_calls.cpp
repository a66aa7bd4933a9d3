#include "hal/linux/v4l2/v4l2_calls.h"

#include <cerrno>
#include <chrono>
#include <cstring>
#include <ctime>

#include <fcntl.h>
#include <sys/ioctl.h>
#include <sys/mman.h>
#include <unistd.h>

namespace stof::hal::linux {
namespace {

class KernelCalls final : public V4l2Calls {
 public:
  int open(const char* path) noexcept override {
    return ::open(path, O_RDWR | O_NONBLOCK | O_CLOEXEC);
  }
  void close(int fd) noexcept override { ::close(fd); }
  int ioctl(int fd, unsigned long request, void* argument) noexcept override {
    return ::ioctl(fd, request, argument);
  }
  const std::uint8_t* map(int fd, std::size_t bytes, std::uint32_t offset) noexcept override {
    void* const data = mmap(nullptr, bytes, PROT_READ, MAP_SHARED, fd, static_cast<off_t>(offset));
    return data == MAP_FAILED ? nullptr : static_cast<const std::uint8_t*>(data);
  }
  void unmap(const std::uint8_t* data, std::size_t bytes) noexcept override {
    munmap(const_cast<std::uint8_t*>(data), bytes);  // NOLINT: gives it back, writes nothing
  }
  int poll(std::span<pollfd> entries, Duration timeout) noexcept override {
    const auto whole = std::chrono::duration_cast<std::chrono::seconds>(timeout);
    timespec limit{};
    limit.tv_sec = static_cast<time_t>(whole.count());
    limit.tv_nsec = static_cast<long>((timeout - whole).count());  // NOLINT: timespec's
    return ppoll(entries.data(), entries.size(), &limit, nullptr);
  }
};

const char* advice(int error) noexcept {
  switch (error) {
    case EACCES:
    case EPERM:
      return "add the user to the group of that device, often video";
    case EBUSY:
      return "another program has it: end that first";
    case ENOTTY:
    case EINVAL:
      return "give a node that captures video, such as /dev/video0";
    default:
      return "check the cable and the device's name";
  }
}

}  // namespace

V4l2Calls& kernel_calls() noexcept {
  static KernelCalls* const calls = new KernelCalls;  // outlives every camera
  return *calls;
}

int ask_driver(V4l2Calls& calls, int fd, unsigned long request, void* argument) noexcept {
  for (;;) {
    if (calls.ioctl(fd, request, argument) >= 0) {
      return 0;
    }
    if (errno != EINTR) {
      return errno;
    }
  }
}

std::string with_advice(const char* what, int error) {
  return std::string(what) + ": " + std::strerror(error) + "; " + advice(error);
}

}  // namespace stof::hal::linux
