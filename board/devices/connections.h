#pragma once

#include <expected>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "board/board.h"
#include "hal/linux/ports/mdns_port.h"
#include "hal/linux/ports/network_interfaces.h"
#include "hal/linux/ports/serial_tty.h"
#include "hal/linux/ports/udp_port.h"

// How a board that runs Linux talks, whatever its cameras are.
namespace stof::board {

struct OpenConnections {
  std::unique_ptr<hal::linux::UdpPort> port;
  std::unique_ptr<hal::linux::UdpPort> beacon;
  std::optional<hal::Peer> to;
  std::optional<hal::linux::SerialTty> serial;
  std::unique_ptr<hal::linux::NetworkInterfaces> network =
      std::make_unique<hal::linux::NetworkInterfaces>();
  std::unique_ptr<hal::linux::MdnsPort> mdns;
  bool other_port = false;  // than the one that was wanted
  std::vector<std::string> notes;
};

std::expected<OpenConnections, Refusal> open_connections(const Connections& wanted);

}  // namespace stof::board
