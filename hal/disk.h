#pragma once

#include <cstddef>
#include <span>

#include "dsp/base/status.h"

namespace stof::hal {

// A disk, a partition or a file in its place, without a file system. For one thread; allocates
// nothing; blocks as long as the medium takes, seconds on a worn one.
class Disk {
 public:
  virtual ~Disk() = default;

  virtual std::size_t bytes() const noexcept = 0;
  // As many as `to` has, from `offset` on. kInvalidArgument: not within the disk; kDeviceError.
  virtual Status read(std::size_t offset, std::span<std::byte> to) noexcept = 0;
  // On the medium after flush(); until then in any order, any part of it, or not at all. Errors as
  // read(), after which some of the bytes may be there.
  virtual Status write(std::size_t offset, std::span<const std::byte> bytes) noexcept = 0;
  virtual Status flush() noexcept = 0;
};

}  // namespace stof::hal
