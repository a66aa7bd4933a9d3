#include "posix/replaced_file.h"

#include <algorithm>
#include <cerrno>
#include <cstdio>

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include "posix/fd.h"
#include "posix/named_file.h"

namespace stof::posix {
namespace {

// Pipes and devices cannot be flushed, nor some folders.
bool flush(int fd) { return ::fsync(fd) == 0 || errno == EINVAL || errno == ENOTSUP; }

bool is_replaceable(const std::string& file) {
  struct stat found{};
  return ::lstat(file.c_str(), &found) != 0 || S_ISREG(found.st_mode);
}

std::string folder_of(const std::string& file) {
  const std::size_t slash = file.rfind('/');
  return slash == std::string::npos ? "." : file.substr(0, std::max<std::size_t>(slash, 1));
}

int write_in_place(const std::string& file, std::span<const std::byte> bytes, mode_t mode) {
  const Fd out(::open(file.c_str(), O_WRONLY | O_CREAT | O_TRUNC | O_NOCTTY | O_CLOEXEC, mode));
  return out.is_open() && write_all(out.get(), bytes) && flush(out.get()) ? 0 : errno;
}

}  // namespace

int replace_file(const std::string& file, std::span<const std::byte> bytes, mode_t mode) {
  if (!is_replaceable(file)) {
    return write_in_place(file, bytes, mode);
  }
  const std::string fresh = file + ".new";
  ::unlink(fresh.c_str());
  const Fd out(::open(fresh.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_NOFOLLOW | O_CLOEXEC, mode));
  if (!out.is_open()) {
    return errno;
  }
  if (!write_all(out.get(), bytes) || !flush(out.get()) ||
      ::rename(fresh.c_str(), file.c_str()) != 0) {
    const int error = errno;
    ::unlink(fresh.c_str());
    return error;
  }
  // The name as well: what it meant before may come back without, which is whole too.
  if (const Fd folder(::open(folder_of(file).c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC));
      folder.is_open()) {
    static_cast<void>(flush(folder.get()));
  }
  return 0;
}

}  // namespace stof::posix
