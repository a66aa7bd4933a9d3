#pragma once

#include <cstddef>
#include <span>

#include "dsp/base/status.h"

namespace stof::hal::linux {

// Of an open disk: a regular file or a block device. Errors: kDeviceError, unless told.

// kUnsupported: it is something else.
Result<std::size_t> bytes_of_disk(int fd) noexcept;
Status read_disk(int fd, std::size_t offset, std::span<std::byte> to) noexcept;
Status write_disk(int fd, std::size_t offset, std::span<const std::byte> bytes) noexcept;
// All that was written is on the medium.
Status flush_disk(int fd) noexcept;
// What is read next there comes from the medium, and not from memory: for what is flushed.
void forget_disk(int fd, std::size_t offset, std::size_t count) noexcept;

}  // namespace stof::hal::linux
