#include "hal/linux/system/watchdog.h"

#include <cerrno>
#include <cstring>

#include <fcntl.h>
#include <linux/watchdog.h>
#include <sys/ioctl.h>
#include <unistd.h>

namespace stof::hal::linux {
namespace {

const char* advice(int error) noexcept {
  switch (error) {
    case ENOENT:
    case ENXIO:
    case ENODEV:
      return "load the driver of the board's watchdog, or switch the watchdog off";
    case EACCES:
    case EPERM:
      return "run as root, or give this user that device";
    case EBUSY:
      return "another program has it, often systemd (RuntimeWatchdogSec): end that first";
    case ENOTTY:
      return "give the name of a watchdog, such as /dev/watchdog0";
    case EINVAL:
      return "the driver does not take that time: choose another one";
    default:
      return "switch the watchdog off";
  }
}

void stop_and_close(int fd) noexcept {
  static_cast<void>(::write(fd, "V", 1));
  ::close(fd);
}

}  // namespace

std::expected<std::unique_ptr<WatchdogDevice>, OpenError> WatchdogDevice::open(
    const WatchdogOptions& options) {
  const auto refused = [&](int error) {
    return std::unexpected(OpenError{"watchdog '" + options.device + "': " + std::strerror(error) +
                                     "; " + advice(error)});
  };
  if (options.timeout < std::chrono::seconds(1) || options.timeout > std::chrono::hours(1)) {
    return refused(EINVAL);
  }
  const int fd = ::open(options.device.c_str(), O_WRONLY | O_CLOEXEC);
  if (fd < 0) {
    return refused(errno);
  }
  // In seconds; the driver rounds up, and answers what it took.
  int seconds = static_cast<int>(options.timeout.count());
  if (ioctl(fd, WDIOC_SETTIMEOUT, &seconds) != 0 || seconds < 1) {
    const int error = seconds < 1 ? EINVAL : errno;
    if (error == ENOTTY) {
      ::close(fd);  // whatever it is, it must not find a 'V' in it
    } else {
      stop_and_close(fd);
    }
    return refused(error);
  }
  watchdog_info info{};
  const bool can_stop =
      ioctl(fd, WDIOC_GETSUPPORT, &info) == 0 && (info.options & WDIOF_MAGICCLOSE) != 0;
  return std::unique_ptr<WatchdogDevice>(
      new WatchdogDevice(fd, std::chrono::seconds(seconds), can_stop));
}

WatchdogDevice::~WatchdogDevice() {
  if (fd_ >= 0) {
    ::close(fd_);
  }
}

Status WatchdogDevice::kick() noexcept {
  int nothing = 0;
  return fd_ >= 0 && ioctl(fd_, WDIOC_KEEPALIVE, &nothing) == 0 ? Status::kOk
                                                                : Status::kDeviceError;
}

Status WatchdogDevice::disarm() noexcept {
  if (fd_ < 0) {
    return Status::kOk;
  }
  if (!can_stop_) {
    return Status::kUnsupported;
  }
  if (::write(fd_, "V", 1) != 1) {
    return Status::kDeviceError;
  }
  ::close(fd_);
  fd_ = -1;
  return Status::kOk;
}

}  // namespace stof::hal::linux
