#include "posix/named_file.h"

#include <cerrno>

#include <fcntl.h>
#include <sys/stat.h>

namespace stof::posix {
namespace {

constexpr mode_t kNamedFileMode = 0666;  // less the umask
constexpr int kNamedFileFlags = O_WRONLY | O_CREAT | O_NOFOLLOW | O_NONBLOCK | O_NOCTTY | O_CLOEXEC;

}  // namespace

std::expected<Fd, int> open_named_file(const std::string& file, bool empty) {
  Fd fd(::open(file.c_str(), kNamedFileFlags, kNamedFileMode));
  struct stat is{};
  if (!fd.is_open() || ::fstat(fd.get(), &is) != 0) {
    return std::unexpected(errno);
  }
  if (!S_ISREG(is.st_mode) && !S_ISCHR(is.st_mode)) {
    return std::unexpected(ENXIO);
  }
  if (empty && S_ISREG(is.st_mode) && ::ftruncate(fd.get(), 0) != 0) {
    return std::unexpected(errno);
  }
  return fd;
}

std::expected<Fd, int> create_named_file(const std::string& file) {
  Fd fd(::open(file.c_str(), kNamedFileFlags | O_EXCL, kNamedFileMode));
  return fd.is_open() ? std::expected<Fd, int>(std::move(fd)) : std::unexpected(errno);
}

bool write_all(int fd, std::span<const std::byte> bytes) {
  while (!bytes.empty()) {
    const ssize_t written = ::write(fd, bytes.data(), bytes.size());
    if (written > 0) {
      bytes = bytes.subspan(static_cast<std::size_t>(written));
    } else if (written == 0 || errno != EINTR) {
      errno = written == 0 ? ENOSPC : errno;
      return false;
    }
  }
  return true;
}

int replace_named_file(const std::string& file, std::span<const std::byte> bytes) {
  struct stat found{};
  const bool there = ::lstat(file.c_str(), &found) == 0;
  if (!there || S_ISREG(found.st_mode)) {
    constexpr mode_t kPermissions = 0777;
    const mode_t mode = there ? found.st_mode & kPermissions : 0666;
    // Of this process: no file of somebody else has this name.
    const std::string fresh = file + "." + std::to_string(::getpid()) + ".new";
    ::unlink(fresh.c_str());
    const Fd out(::open(fresh.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_NOFOLLOW | O_CLOEXEC, mode));
    if (out.is_open()) {
      if (there) {
        static_cast<void>(::fchmod(out.get(), mode));  // what the umask took; less is no harm
      }
      const bool whole = write_all(out.get(), bytes);
      if (whole && ::rename(fresh.c_str(), file.c_str()) == 0) {
        return 0;
      }
      const int error = errno;
      ::unlink(fresh.c_str());
      if (!whole) {
        return error;
      }
      // A mount of this one file, or another user's in a folder of all.
    }
  }
  const auto out = open_named_file(file, true);
  if (!out) {
    return out.error();
  }
  return write_all(out->get(), bytes) ? 0 : errno;
}

}  // namespace stof::posix
