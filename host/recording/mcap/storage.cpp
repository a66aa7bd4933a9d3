#include "host/recording/mcap/storage.h"

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <utility>

#include <fcntl.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include "dataset/files/file.h"
#include "posix/named_file.h"

namespace stof::mcap {
namespace {

const char* remedy(int error) {
  switch (error) {
    case ENOSPC:
    case EDQUOT:
    case EFBIG:
      return "make room, or record to another disk";
    case EEXIST:
      return "give another name, or --force to replace it";
    case ENOENT:
    case ENOTDIR:
      return "check the path and make the folder";
    case EISDIR:
    case ENXIO:
      return "give the name of a file";
    case ELOOP:
      return "a link is not written through: give the name of the file itself";
    default:
      return "check the path, its permissions and the disk";
  }
}

std::unexpected<Problem> refuse(const std::filesystem::path& file, int error) {
  return dataset::refuse(file, std::strerror(error), remedy(error));
}

bool is_regular(int fd, std::uint64_t& size) {
  struct stat status{};
  if (fstat(fd, &status) != 0 || !S_ISREG(status.st_mode)) {
    return false;
  }
  size = static_cast<std::uint64_t>(status.st_size);
  return true;
}

// Keeps all others out until the descriptor is closed. A file system without locks keeps nobody
// out.
bool is_free(const posix::Fd& fd) {
  return flock(fd.get(), LOCK_EX | LOCK_NB) == 0 || errno != EWOULDBLOCK;
}

std::unexpected<Problem> in_use(const std::filesystem::path& file) {
  return dataset::refuse(file, "is being written by another program",
                         "wait until that ends, or give another name");
}

}  // namespace

std::expected<FileSink, Problem> FileSink::open(const std::filesystem::path& file,
                                                Existing existing) {
  std::error_code error;
  const std::filesystem::file_status status = std::filesystem::status(file, error);
  if (std::filesystem::exists(status) && !std::filesystem::is_regular_file(status)) {
    return dataset::refuse(file, "is not a file", "give the name of a file");
  }
  if (std::filesystem::is_symlink(std::filesystem::symlink_status(file, error))) {
    return dataset::refuse(file, "is a link", remedy(ELOOP));
  }
  if (existing == Existing::kRefuse) {
    auto created = posix::create_named_file(file.string());
    if (!created) {
      return refuse(file, created.error());
    }
    static_cast<void>(is_free(*created));
    return FileSink(file, std::move(*created));
  }
  auto opened = posix::open_named_file(file.string(), false);
  std::uint64_t size = 0;
  if (!opened) {
    return refuse(file, opened.error());
  }
  if (!is_regular(opened->get(), size)) {
    return dataset::refuse(file, "is not a file", "give the name of a file");
  }
  if (existing == Existing::kAppend) {
    return lseek(opened->get(), 0, SEEK_END) < 0
               ? std::expected<FileSink, Problem>(refuse(file, errno))
               : FileSink(file, std::move(*opened));
  }
  if (!is_free(*opened)) {  // before it is emptied
    return in_use(file);
  }
  if (ftruncate(opened->get(), 0) != 0) {
    return refuse(file, errno);
  }
  return FileSink(file, std::move(*opened));
}

std::unexpected<Problem> FileSink::problem(int error) const { return refuse(file_, error); }

std::expected<void, Problem> FileSink::write(Bytes bytes) {
  while (!bytes.empty()) {
    const ssize_t written = ::write(fd_.get(), bytes.data(), bytes.size());
    if (written < 0 && errno == EINTR) {
      continue;
    }
    if (written <= 0) {
      return problem(written < 0 ? errno : EIO);
    }
    bytes = bytes.subspan(static_cast<std::size_t>(written));
  }
  return {};
}

std::expected<void, Problem> FileSink::sync() {
  if (fdatasync(fd_.get()) != 0 && errno != EINVAL) {  // EINVAL: nothing that can be flushed
    return problem(errno);
  }
  return {};
}

std::expected<void, Problem> FileSink::cut_to(std::uint64_t size) {
  const auto end = static_cast<off_t>(size);
  if (ftruncate(fd_.get(), end) != 0 || lseek(fd_.get(), end, SEEK_SET) != end) {
    return problem(errno);
  }
  return {};
}

std::expected<FileSource, Problem> FileSource::open(const std::filesystem::path& file) {
  std::error_code error;
  if (!std::filesystem::is_regular_file(file, error)) {  // whose open() may wait for ever
    return dataset::refuse(
        file, std::filesystem::exists(file, error) ? "is not a file" : "does not exist",
        "give a recording");
  }
  posix::Fd fd(::open(file.c_str(), O_RDONLY | O_CLOEXEC));
  if (!fd.is_open()) {
    return refuse(file, errno);
  }
  std::uint64_t size = 0;
  if (!is_regular(fd.get(), size)) {
    return dataset::refuse(file, "is not a file", "give a recording");
  }
  return FileSource(std::move(fd), size);
}

std::expected<void, Problem> FileSource::lock(const std::filesystem::path& file) {
  return is_free(fd_) ? std::expected<void, Problem>() : in_use(file);
}

bool FileSource::is_locked() const {
  if (flock(fd_.get(), LOCK_SH | LOCK_NB) != 0) {
    return errno == EWOULDBLOCK;
  }
  flock(fd_.get(), LOCK_UN);
  return false;
}

bool FileSource::read(std::uint64_t offset, std::span<std::byte> to) const {
  if (offset > size_ || to.size() > size_ - offset) {
    return false;
  }
  while (!to.empty()) {
    const ssize_t count = pread(fd_.get(), to.data(), to.size(), static_cast<off_t>(offset));
    if (count < 0 && errno == EINTR) {
      continue;
    }
    if (count <= 0) {
      return false;
    }
    to = to.subspan(static_cast<std::size_t>(count));
    offset += static_cast<std::uint64_t>(count);
  }
  return true;
}

bool MemorySource::read(std::uint64_t offset, std::span<std::byte> to) const {
  if (offset > bytes_.size() || to.size() > bytes_.size() - offset) {
    return false;
  }
  std::ranges::copy(bytes_.subspan(static_cast<std::size_t>(offset), to.size()), to.begin());
  return true;
}

}  // namespace stof::mcap
