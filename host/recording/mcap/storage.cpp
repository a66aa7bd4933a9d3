#include "host/recording/mcap/storage.h"

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <utility>

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include "dataset/files/file.h"

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
      return "give the name of a file";
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

}  // namespace

std::expected<FileSink, Problem> FileSink::open(const std::filesystem::path& file,
                                                Existing existing) {
  std::error_code error;
  const std::filesystem::file_status status = std::filesystem::status(file, error);
  if (std::filesystem::exists(status) && !std::filesystem::is_regular_file(status)) {
    return dataset::refuse(file, "is not a file", "give the name of a file");
  }
  int flags = O_WRONLY | O_CLOEXEC;
  switch (existing) {
    case Existing::kRefuse:
      flags |= O_CREAT | O_EXCL;
      break;
    case Existing::kReplace:
      flags |= O_CREAT | O_TRUNC;
      break;
    case Existing::kAppend:
      flags |= O_APPEND;
      break;
  }
  constexpr mode_t kMode = 0644;
  const int fd = ::open(file.c_str(), flags, kMode);
  if (fd < 0) {
    return refuse(file, errno);
  }
  return FileSink(file, fd);
}

FileSink::FileSink(FileSink&& other) noexcept
    : file_(std::move(other.file_)), fd_(std::exchange(other.fd_, -1)) {}

FileSink::~FileSink() {
  if (fd_ >= 0) {
    ::close(fd_);
  }
}

std::unexpected<Problem> FileSink::problem(int error) const { return refuse(file_, error); }

std::expected<void, Problem> FileSink::write(Bytes bytes) {
  while (!bytes.empty()) {
    const ssize_t written = ::write(fd_, bytes.data(), bytes.size());
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
  if (fdatasync(fd_) != 0 && errno != EINVAL) {  // EINVAL: nothing that can be flushed
    return problem(errno);
  }
  return {};
}

std::expected<void, Problem> FileSink::cut_to(std::uint64_t size) {
  const auto end = static_cast<off_t>(size);
  if (ftruncate(fd_, end) != 0 || lseek(fd_, end, SEEK_SET) != end) {
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
  const int fd = ::open(file.c_str(), O_RDONLY | O_CLOEXEC);
  if (fd < 0) {
    return refuse(file, errno);
  }
  std::uint64_t size = 0;
  if (!is_regular(fd, size)) {
    ::close(fd);
    return dataset::refuse(file, "is not a file", "give a recording");
  }
  return FileSource(fd, size);
}

FileSource::FileSource(FileSource&& other) noexcept
    : fd_(std::exchange(other.fd_, -1)), size_(other.size_) {}

FileSource::~FileSource() {
  if (fd_ >= 0) {
    ::close(fd_);
  }
}

bool FileSource::read(std::uint64_t offset, std::span<std::byte> to) const {
  if (offset > size_ || to.size() > size_ - offset) {
    return false;
  }
  while (!to.empty()) {
    const ssize_t count = pread(fd_, to.data(), to.size(), static_cast<off_t>(offset));
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
