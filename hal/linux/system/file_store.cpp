#include "hal/linux/system/file_store.h"

#include <algorithm>
#include <cerrno>
#include <cstdio>

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

namespace stof::hal::linux {
namespace {

class Fd {
 public:
  explicit Fd(int fd) noexcept : fd_(fd) {}
  ~Fd() {
    if (fd_ >= 0) {
      ::close(fd_);
    }
  }
  Fd(const Fd&) = delete;
  Fd& operator=(const Fd&) = delete;
  int get() const noexcept { return fd_; }
  explicit operator bool() const noexcept { return fd_ >= 0; }

 private:
  int fd_;
};

template <typename Name>
void join(std::string_view name, std::string_view ending, Name& to) noexcept {
  std::ranges::copy(ending, std::ranges::copy(name, to.begin()).out);
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
  const Fd folder(::open(name, O_RDONLY | O_DIRECTORY | O_CLOEXEC));
  // Some file systems do not flush folders and say so; there is nothing else to do then.
  return folder && (::fsync(folder.get()) == 0 || errno == EINVAL);
}

Status judge(bool good) noexcept { return good ? Status::kOk : Status::kDeviceError; }

}  // namespace

FileStore::FileStore(std::string_view name) noexcept {
  name = name.substr(0, kMostName);
  join(name, "", name_);
  join(name, ".new", new_);
  join(name, ".bad", bad_);
  const std::size_t slash = name.rfind('/');
  if (slash == std::string_view::npos) {
    join(".", "", folder_);
  } else {
    join(name.substr(0, std::max<std::size_t>(slash, 1)), "", folder_);
  }
}

Result<std::size_t> FileStore::load(std::span<std::byte> space) noexcept {
  const Fd file(::open(name_.data(), O_RDONLY | O_CLOEXEC));
  if (!file) {
    return errno == ENOENT ? Result<std::size_t>(0) : fail(Status::kDeviceError);
  }
  std::size_t bytes = 0;
  std::byte more{};
  while (true) {
    const bool full = bytes == space.size();
    const ssize_t got =
        ::read(file.get(), full ? &more : space.data() + bytes, full ? 1 : space.size() - bytes);
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
  constexpr mode_t kReadable = 0644;
  const Fd file(::open(new_.data(), O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, kReadable));
  return judge(file && write_all(file.get(), bytes) && ::fsync(file.get()) == 0);
}

Status FileStore::save(std::span<const std::byte> bytes) noexcept {
  if (write_new(bytes) != Status::kOk || std::rename(new_.data(), name_.data()) != 0) {
    ::unlink(new_.data());
    return Status::kDeviceError;
  }
  return judge(flush_folder(folder_.data()));
}

Status FileStore::set_aside() noexcept {
  return judge(std::rename(name_.data(), bad_.data()) == 0 && flush_folder(folder_.data()));
}

}  // namespace stof::hal::linux
