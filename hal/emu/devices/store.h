#pragma once

#include <cstddef>
#include <optional>
#include <span>
#include <vector>

#include "hal/store.h"

namespace stof::hal::emu {

// Bytes in memory, and a medium that fails when asked to.
class Store final : public hal::Store {
 public:
  Result<std::optional<std::size_t>> load(std::span<std::byte> space) noexcept override;
  Status save(std::span<const std::byte> bytes) noexcept override;
  Status set_aside() noexcept override;

  // From now on the medium takes nothing and gives nothing, and says why.
  void break_down(bool broken, Status why = Status::kDeviceError) noexcept {
    broken_ = broken;
    why_ = why;
  }
  // The bytes that load() gives, from now on there are some; for damaged documents.
  std::vector<std::byte>& bytes() noexcept {
    there_ = true;
    return bytes_;
  }
  const std::vector<std::byte>& aside() const noexcept { return aside_; }
  int saves() const noexcept { return saves_; }

 private:
  std::vector<std::byte> bytes_;
  std::vector<std::byte> aside_;
  int saves_ = 0;
  bool there_ = false;
  bool broken_ = false;
  Status why_ = Status::kDeviceError;
};

}  // namespace stof::hal::emu
