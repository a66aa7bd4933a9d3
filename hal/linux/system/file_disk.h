#pragma once

#include <cstddef>
#include <memory>
#include <string>
#include <utility>

#include "hal/disk.h"
#include "posix/fd.h"

namespace stof::hal::linux {

// A partition, or a file of its size; one that is read-only is opened, and takes no writes.
class FileDisk final : public Disk {
 public:
  // kDeviceError: it cannot be opened; kUnsupported: it is neither a file nor a block device.
  static Result<std::unique_ptr<FileDisk>> open(const std::string& name);

  std::size_t bytes() const noexcept override { return bytes_; }
  Status read(std::size_t offset, std::span<std::byte> to) noexcept override;
  Status write(std::size_t offset, std::span<const std::byte> bytes) noexcept override;
  Status flush() noexcept override;

 private:
  FileDisk(posix::Fd file, std::size_t bytes) noexcept : file_(std::move(file)), bytes_(bytes) {}
  bool holds(std::size_t offset, std::size_t count) const noexcept {
    return offset <= bytes_ && count <= bytes_ - offset;
  }

  posix::Fd file_;
  std::size_t bytes_;
};

}  // namespace stof::hal::linux
