#include "hal/linux/system/file_disk.h"

#include <fcntl.h>

#include "hal/linux/system/disk_calls.h"

namespace stof::hal::linux {

Result<std::unique_ptr<FileDisk>> FileDisk::open(const std::string& name) {
  constexpr int kFlags = O_NONBLOCK | O_NOCTTY | O_CLOEXEC;
  posix::Fd file(::open(name.c_str(), O_RDWR | kFlags));
  if (!file.is_open()) {
    file.reset(::open(name.c_str(), O_RDONLY | kFlags));
  }
  if (!file.is_open()) {
    return fail(Status::kDeviceError);
  }
  const Result<std::size_t> bytes = bytes_of_disk(file.get());
  if (!bytes) {
    return fail(bytes.error());
  }
  return std::unique_ptr<FileDisk>(new FileDisk(std::move(file), *bytes));
}

Status FileDisk::read(std::size_t offset, std::span<std::byte> to) noexcept {
  return holds(offset, to.size()) ? read_disk(file_.get(), offset, to) : Status::kInvalidArgument;
}

Status FileDisk::write(std::size_t offset, std::span<const std::byte> bytes) noexcept {
  return holds(offset, bytes.size()) ? write_disk(file_.get(), offset, bytes)
                                     : Status::kInvalidArgument;
}

Status FileDisk::flush() noexcept { return flush_disk(file_.get()); }

}  // namespace stof::hal::linux
