#include "board/devices/lines.h"

#include <utility>

#include "hal/linux/ports/peer_address.h"

namespace stof::board {

std::expected<LinesOpen, Refusal> open_lines(const Lines& wanted) {
  LinesOpen lines;
  auto port = hal::linux::UdpPort::open({.port = wanted.udp_port, .dscp = wanted.dscp});
  if (!port) {
    return std::unexpected(Refusal{port.error().message});
  }
  lines.port = std::move(*port);
  if (!wanted.to.empty()) {
    const auto peer = hal::linux::resolve(wanted.to);
    if (!peer) {
      return std::unexpected(Refusal{peer.error().message});
    }
    lines.to = *peer;
  }
  if (!wanted.serial.empty()) {
    auto serial = hal::linux::SerialTty::open(
        {.device = wanted.serial, .baud = wanted.baud, .flow_control = wanted.flow_control});
    if (!serial) {
      return std::unexpected(Refusal{serial.error()});
    }
    lines.serial = std::move(*serial);
  }
  if (wanted.mdns) {
    auto mdns = hal::linux::MdnsPort::open();
    if (mdns) {
      lines.mdns = std::move(*mdns);
    } else {
      lines.notes.push_back("no mDNS: " + mdns.error().message);
    }
  }
  return lines;
}

}  // namespace stof::board
