#pragma once

#include <array>
#include <cstddef>
#include <optional>

#include "firmware/update/boot_choice.h"
#include "hal/slots.h"

namespace stof::update {

// The sector of autoboot.txt on a disk: found where a start looks for it, changed in place. For one
// thread.
class BootSector {
 public:
  // Looks through the boot partition: blocks. None: there is no such sector.
  static std::optional<BootSector> find(hal::Slots& slots);

  const BootChoice& choice() const noexcept { return choice_; }
  // Writes it where another one stands there. kTimeout: under way, repeat; kOk: it stands there;
  // kDeviceError: one of both, or two bytes of each. No other write may be under way.
  Status set(const BootChoice& choice) noexcept;

 private:
  BootSector(hal::Slots& slots, std::size_t offset, const BootChoice& choice) noexcept
      : slots_(&slots), offset_(offset), choice_(choice) {}

  hal::Slots* slots_;
  std::size_t offset_;
  BootChoice choice_;
  bool under_way_ = false;
  std::array<std::byte, kSectorBytes> sector_{};
};

}  // namespace stof::update
