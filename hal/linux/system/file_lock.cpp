#include "hal/linux/system/file_lock.h"

#include <cerrno>
#include <thread>
#include <utility>
#include <vector>

#include <fcntl.h>
#include <sys/file.h>
#include <sys/stat.h>

#include "posix/fd.h"

namespace stof::hal::linux {

Status hold_file(const std::string& name, bool make, std::chrono::milliseconds patience) {
  constexpr std::chrono::milliseconds kStep(20);
  constexpr mode_t kOwnerAlone = 0600;
  const int flags = O_NONBLOCK | O_NOCTTY | O_CLOEXEC | (make ? O_RDWR | O_CREAT | O_NOFOLLOW : 0);
  posix::Fd file(::open(name.c_str(), flags, kOwnerAlone));
  struct stat found{};
  if (!file.is_open() || ::fstat(file.get(), &found) != 0) {
    return Status::kDeviceError;
  }
  if (!S_ISREG(found.st_mode) && !S_ISBLK(found.st_mode)) {
    return Status::kUnsupported;
  }
  const auto end = std::chrono::steady_clock::now() + patience;
  while (::flock(file.get(), LOCK_EX | LOCK_NB) != 0) {
    if (errno != EWOULDBLOCK && errno != EINTR) {
      return Status::kDeviceError;
    }
    if (std::chrono::steady_clock::now() >= end) {
      return Status::kWouldBlock;
    }
    std::this_thread::sleep_for(kStep);
  }
  static std::vector<posix::Fd> held;
  held.push_back(std::move(file));
  return Status::kOk;
}

}  // namespace stof::hal::linux
