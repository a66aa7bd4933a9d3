#pragma once

#include <array>
#include <cstddef>

#include "hal/network.h"

namespace stof::hal::linux {

// Asks the kernel (rtnetlink). Without sockets of that kind there are no addresses.
class Network final : public hal::Network {
 public:
  Network() noexcept;
  ~Network() override;
  Network(const Network&) = delete;
  Network& operator=(const Network&) = delete;

  std::size_t addresses(std::span<InterfaceAddress> space) noexcept override;

 private:
  bool request() noexcept;
  bool interface_flags(unsigned index, unsigned& flags) const noexcept;

  int netlink_ = -1;
  int any_ = -1;  // for questions about interfaces
  unsigned sequence_ = 0;
  alignas(8) std::array<std::byte, 16384> buffer_{};
};

}  // namespace stof::hal::linux
