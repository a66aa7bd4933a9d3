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

}  // namespace stof::posix
