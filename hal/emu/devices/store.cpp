#include "hal/emu/devices/store.h"

#include <algorithm>
#include <utility>

namespace stof::hal::emu {

Result<std::optional<std::size_t>> Store::load(std::span<std::byte> space) noexcept {
  if (broken_) {
    return fail(why_);
  }
  if (!there_) {
    return std::nullopt;
  }
  if (bytes_.size() > space.size()) {
    return fail(Status::kTooLarge);
  }
  std::ranges::copy(bytes_, space.begin());
  return bytes_.size();
}

Status Store::save(std::span<const std::byte> bytes) noexcept {
  if (broken_) {
    return why_;
  }
  bytes_.assign(bytes.begin(), bytes.end());
  there_ = true;
  ++saves_;
  return Status::kOk;
}

Status Store::set_aside() noexcept {
  if (broken_) {
    return why_;
  }
  aside_ = std::exchange(bytes_, {});
  there_ = false;
  return Status::kOk;
}

}  // namespace stof::hal::emu
