#include "hal/linux/system/file_store.h"

#include <algorithm>
#include <cerrno>
#include <cstdio>
#include <utility>

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include "posix/fd.h"

namespace stof::hal::linux {
namespace {

constexpr mode_t kReadable = 0644;
constexpr mode_t kOwnerAlone = 0600;

// The folder of a file's name.
std::string folder_of(const std::string& name) {
  const std::size_t slash = name.rfind('/');
  return slash == std::string::npos ? "." : name.substr(0, std::max<std::size_t>(slash, 1));
}

bool write_all(int fd, std::span<const std::byte> bytes) noexcept {
  while (!bytes.empty()) {
    const ssize_t written = ::write(fd, bytes.data(), bytes.size());
    if (written > 0) {
      bytes = bytes.subspan(static_cast<std::size_t>(written));
    } else if (written == 0 || errno != EINTR) {
      return false;
    }
  }
  return true;
}

bool flush_folder(const char* name) noexcept {
  const posix::Fd folder(::open(name, O_RDONLY | O_DIRECTORY | O_CLOEXEC));
  // Some file systems do not flush folders and say so; there is nothing else to do then.
  return folder.is_open() && (::fsync(folder.get()) == 0 || errno == EINVAL);
}

// A regular file, open to be read; not open: there is none. kUnsupported: it is something else.
Result<posix::Fd> open_file(const char* name) noexcept {
  struct stat found{};
  if (::lstat(name, &found) != 0) {
    return errno == ENOENT || errno == ENOTDIR ? Result<posix::Fd>(posix::Fd())
                                               : fail(Status::kDeviceError);
  }
  if (!S_ISREG(found.st_mode)) {
    return fail(Status::kUnsupported);
  }
  // It may have become something else meanwhile: neither a link is followed, nor a device waited
  // for.
  posix::Fd file(::open(name, O_RDONLY | O_NOFOLLOW | O_NONBLOCK | O_NOCTTY | O_CLOEXEC));
  if (!file.is_open() || ::fstat(file.get(), &found) != 0) {
    return fail(Status::kDeviceError);
  }
  if (!S_ISREG(found.st_mode)) {
    return fail(Status::kUnsupported);
  }
  return file;
}

// A file system that cannot be written has private files too.
bool make_private(int fd) noexcept {
  constexpr mode_t kOthers = 0077;
  struct stat found{};
  return ::fstat(fd, &found) == 0 &&
         ((found.st_mode & kOthers) == 0 || ::fchmod(fd, kOwnerAlone) == 0);
}

// Nothing that is no regular file is in the way.
bool free_for_file(const char* name) noexcept {
  struct stat found{};
  return ::lstat(name, &found) != 0 ? errno == ENOENT : S_ISREG(found.st_mode);
}

Status judge(bool good) noexcept { return good ? Status::kOk : Status::kDeviceError; }

}  // namespace

FileStore::FileStore(std::string name, Readers readers)
    : name_(std::move(name)),
      new_(name_ + ".new"),
      bad_(name_ + ".bad"),
      folder_(folder_of(name_)),
      readers_(readers) {}

// Secrets that cannot be reached are not the same as none: their folder has to be there.
Result<posix::Fd> FileStore::open() const noexcept {
  struct stat folder{};
  if (readers_ == Readers::kOwner &&
      (::stat(folder_.c_str(), &folder) != 0 || !S_ISDIR(folder.st_mode))) {
    return fail(Status::kDeviceError);
  }
  return open_file(name_.c_str());
}

Result<std::optional<std::size_t>> FileStore::load(std::span<std::byte> space) noexcept {
  const Result<posix::Fd> file = open();
  if (!file) {
    return fail(file.error());
  }
  if (!file->is_open()) {
    return std::nullopt;
  }
  if (readers_ == Readers::kOwner && !make_private(file->get())) {
    return fail(Status::kDeviceError);
  }
  std::size_t bytes = 0;
  std::byte more{};
  while (true) {
    const bool full = bytes == space.size();
    const ssize_t got =
        ::read(file->get(), full ? &more : space.data() + bytes, full ? 1 : space.size() - bytes);
    if (got == 0) {
      return bytes;
    }
    if (got > 0 && full) {
      return fail(Status::kTooLarge);
    }
    if (got > 0) {
      bytes += static_cast<std::size_t>(got);
    } else if (errno != EINTR) {
      return fail(Status::kDeviceError);
    }
  }
}

Status FileStore::write_new(std::span<const std::byte> bytes) const noexcept {
  const mode_t mode = readers_ == Readers::kOwner ? kOwnerAlone : kReadable;
  if (!free_for_file(new_.c_str())) {
    return Status::kDeviceError;
  }
  ::unlink(new_.c_str());  // of a save that a power cut ended
  const posix::Fd file(
      ::open(new_.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_NOFOLLOW | O_CLOEXEC, mode));
  return judge(file.is_open() && write_all(file.get(), bytes) && ::fsync(file.get()) == 0);
}

Status FileStore::save(std::span<const std::byte> bytes) noexcept {
  if (const Result<posix::Fd> file = open(); !file) {
    return file.error();
  }
  if (write_new(bytes) != Status::kOk || std::rename(new_.c_str(), name_.c_str()) != 0) {
    if (free_for_file(new_.c_str())) {
      ::unlink(new_.c_str());
    }
    return Status::kDeviceError;
  }
  return judge(flush_folder(folder_.c_str()));
}

Status FileStore::set_aside() noexcept {
  if (const Result<posix::Fd> file = open(); !file) {
    return file.error();
  }
  return judge(free_for_file(bad_.c_str()) && std::rename(name_.c_str(), bad_.c_str()) == 0 &&
               flush_folder(folder_.c_str()));
}

}  // namespace stof::hal::linux
