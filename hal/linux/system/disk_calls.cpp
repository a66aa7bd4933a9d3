#include "hal/linux/system/disk_calls.h"

#include <cerrno>

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

namespace stof::hal::linux {

Result<std::size_t> bytes_of_disk(int fd) noexcept {
  struct stat found{};
  if (::fstat(fd, &found) != 0) {
    return fail(Status::kDeviceError);
  }
  if (!S_ISREG(found.st_mode) && !S_ISBLK(found.st_mode)) {
    return fail(Status::kUnsupported);
  }
  const off_t end = ::lseek(fd, 0, SEEK_END);
  return end > 0 ? Result<std::size_t>(static_cast<std::size_t>(end)) : fail(Status::kDeviceError);
}

Status read_disk(int fd, std::size_t offset, std::span<std::byte> to) noexcept {
  while (!to.empty()) {
    const ssize_t got = ::pread(fd, to.data(), to.size(), static_cast<off_t>(offset));
    if (got > 0) {
      to = to.subspan(static_cast<std::size_t>(got));
      offset += static_cast<std::size_t>(got);
    } else if (got == 0 || errno != EINTR) {
      return Status::kDeviceError;
    }
  }
  return Status::kOk;
}

Status write_disk(int fd, std::size_t offset, std::span<const std::byte> bytes) noexcept {
  while (!bytes.empty()) {
    const ssize_t written = ::pwrite(fd, bytes.data(), bytes.size(), static_cast<off_t>(offset));
    if (written > 0) {
      bytes = bytes.subspan(static_cast<std::size_t>(written));
      offset += static_cast<std::size_t>(written);
    } else if (written == 0 || errno != EINTR) {
      return Status::kDeviceError;
    }
  }
  return Status::kOk;
}

Status flush_disk(int fd) noexcept {
  return ::fdatasync(fd) == 0 ? Status::kOk : Status::kDeviceError;
}

void forget_disk(int fd, std::size_t offset, std::size_t count) noexcept {
  static_cast<void>(::posix_fadvise(fd, static_cast<off_t>(offset), static_cast<off_t>(count),
                                    POSIX_FADV_DONTNEED));
}

}  // namespace stof::hal::linux
