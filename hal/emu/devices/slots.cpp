#include "hal/emu/devices/slots.h"

#include <algorithm>

namespace stof::hal::emu {

Status Slots::read(DiskPart part, std::size_t offset, std::span<std::byte> to) noexcept {
  const std::vector<std::byte>& from = of(part);
  if (offset > from.size() || to.size() > from.size() - offset) {
    return Status::kInvalidArgument;
  }
  std::copy_n(from.begin() + static_cast<std::ptrdiff_t>(offset), to.size(), to.begin());
  if (worn_byte && part == DiskPart::kSlotB && *worn_byte >= offset &&
      *worn_byte - offset < to.size()) {
    to[*worn_byte - offset] ^= std::byte{1};
  }
  return Status::kOk;
}

void Slots::write(DiskPart part, std::size_t offset, std::span<const std::byte> bytes) noexcept {
  const std::size_t room = of(part).size();
  if (offset > room || bytes.size() > room - offset) {
    last_ = Status::kInvalidArgument;
    return;
  }
  if (breaks_after == 0) {
    last_ = Status::kDeviceError;
    return;
  }
  breaks_after -= breaks_after > 0 ? 1 : 0;
  log_.push_back({.part = part, .offset = offset, .bytes = {bytes.begin(), bytes.end()}});
  given_ = bytes;
  left_ = delay;
  last_ = Status::kTimeout;
}

// Whoever changes the bytes while they are written has what he has: they are read at the end.
Status Slots::progress() noexcept {
  if (last_ != Status::kTimeout || left_-- > 0) {
    return last_;
  }
  Write& done = log_.back();
  done.bytes.assign(given_.begin(), given_.end());
  done.flushed = true;
  std::ranges::copy(done.bytes, disk_[static_cast<std::size_t>(done.part)].begin() +
                                    static_cast<std::ptrdiff_t>(done.offset));
  last_ = Status::kOk;
  return last_;
}

}  // namespace stof::hal::emu
