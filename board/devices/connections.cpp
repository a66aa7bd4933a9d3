#include "board/devices/connections.h"

#include <utility>

#include "hal/linux/ports/peer_address.h"

namespace stof::board {

std::expected<OpenConnections, Refusal> open_connections(const Connections& wanted) {
  OpenConnections connections;
  auto port = hal::linux::UdpPort::open({.port = wanted.udp_port, .dscp = wanted.dscp});
  if (!port) {
    return std::unexpected(Refusal{port.error().message});
  }
  connections.port = std::move(*port);
  if (!wanted.to.empty()) {
    const auto peer = hal::linux::resolve(wanted.to);
    if (!peer) {
      return std::unexpected(Refusal{peer.error().message});
    }
    connections.to = *peer;
  }
  if (!wanted.serial.empty()) {
    auto serial = hal::linux::SerialTty::open(
        {.device = wanted.serial, .baud = wanted.baud, .flow_control = wanted.flow_control});
    if (!serial) {
      return std::unexpected(Refusal{serial.error()});
    }
    connections.serial = std::move(*serial);
  }
  if (wanted.mdns) {
    auto mdns = hal::linux::MdnsPort::open();
    if (mdns) {
      connections.mdns = std::move(*mdns);
    } else {
      connections.notes.push_back("no mDNS: " + mdns.error().message);
    }
  }
  return connections;
}

}  // namespace stof::board
