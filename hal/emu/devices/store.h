#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "hal/store.h"

namespace stof::hal::emu {

// Bytes in memory, and a medium that fails when asked to.
class Store final : public hal::Store {
 public:
  Result<std::size_t> load(std::span<std::byte> space) noexcept override;
  Status save(std::span<const std::byte> bytes) noexcept override;
  Status set_aside() noexcept override;

  // From now on the medium takes nothing and gives nothing.
  void break_down(bool broken) noexcept { broken_ = broken; }
  // The bytes that load() gives; for damaged documents.
  std::vector<std::byte>& bytes() noexcept { return bytes_; }
  const std::vector<std::byte>& aside() const noexcept { return aside_; }
  int saves() const noexcept { return saves_; }

 private:
  std::vector<std::byte> bytes_;
  std::vector<std::byte> aside_;
  int saves_ = 0;
  bool broken_ = false;
};

}  // namespace stof::hal::emu
