#pragma once

#include <array>
#include <cstddef>

#include "hal/network_interfaces.h"

namespace stof::hal::linux {

// Asks the kernel (rtnetlink). Without sockets of that kind there are no addresses.
class NetworkInterfaces final : public hal::NetworkInterfaces {
 public:
  NetworkInterfaces() noexcept;
  ~NetworkInterfaces() override;
  NetworkInterfaces(const NetworkInterfaces&) = delete;
  NetworkInterfaces& operator=(const NetworkInterfaces&) = delete;

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
