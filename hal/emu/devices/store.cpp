#include "hal/emu/devices/store.h"

#include <algorithm>
#include <utility>

namespace stof::hal::emu {

Result<std::size_t> Store::load(std::span<std::byte> space) noexcept {
  if (broken_) {
    return fail(Status::kDeviceError);
  }
  if (bytes_.size() > space.size()) {
    return fail(Status::kTooLarge);
  }
  std::ranges::copy(bytes_, space.begin());
  return bytes_.size();
}

Status Store::save(std::span<const std::byte> bytes) noexcept {
  if (broken_) {
    return Status::kDeviceError;
  }
  bytes_.assign(bytes.begin(), bytes.end());
  ++saves_;
  return Status::kOk;
}

Status Store::set_aside() noexcept {
  if (broken_) {
    return Status::kDeviceError;
  }
  aside_ = std::exchange(bytes_, {});
  return Status::kOk;
}

}  // namespace stof::hal::emu
