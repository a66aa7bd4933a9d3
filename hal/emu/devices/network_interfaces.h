#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <span>

#include "hal/network_interfaces.h"

namespace stof::hal::emu {

// Network interfaces as a test sets them.
class NetworkInterfaces final : public hal::NetworkInterfaces {
 public:
  // Those beyond kMost are left out.
  void set(std::span<const InterfaceAddress> addresses) noexcept {
    count_ = std::min(addresses.size(), kMost);
    std::ranges::copy(addresses.first(count_), addresses_.begin());
  }

  std::size_t addresses(std::span<InterfaceAddress> space) noexcept override {
    const std::size_t count = std::min(count_, space.size());
    std::ranges::copy(std::span(addresses_).first(count), space.begin());
    return count;
  }

 private:
  static constexpr std::size_t kMost = 32;

  std::array<InterfaceAddress, kMost> addresses_{};
  std::size_t count_ = 0;
};

}  // namespace stof::hal::emu
