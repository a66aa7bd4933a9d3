#include "hal/emu/devices/disk.h"

#include <algorithm>

namespace stof::hal::emu {

Status Disk::read(std::size_t offset, std::span<std::byte> to) noexcept {
  if (!holds(offset, to.size())) {
    return Status::kInvalidArgument;
  }
  if (offset < unreadable_end && offset + to.size() > unreadable_begin) {
    return Status::kDeviceError;
  }
  std::copy_n(content_.begin() + static_cast<std::ptrdiff_t>(offset), to.size(), to.begin());
  return Status::kOk;
}

Status Disk::write(std::size_t offset, std::span<const std::byte> bytes) noexcept {
  if (!holds(offset, bytes.size())) {
    return Status::kInvalidArgument;
  }
  if (breaks_after == 0) {
    return Status::kDeviceError;
  }
  breaks_after -= breaks_after > 0 ? 1 : 0;
  std::ranges::copy(bytes, content_.begin() + static_cast<std::ptrdiff_t>(offset));
  log_.push_back({.offset = offset, .bytes = {bytes.begin(), bytes.end()}});
  return Status::kOk;
}

Status Disk::flush() noexcept {
  log_.push_back({.offset = 0, .bytes = {}});
  return Status::kOk;
}

}  // namespace stof::hal::emu
