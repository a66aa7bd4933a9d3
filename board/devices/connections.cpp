#include "board/devices/connections.h"

#include <cstdint>
#include <memory>
#include <string>
#include <utility>

#include "hal/linux/ports/peer_address.h"

namespace stof::board {

namespace {

using hal::linux::UdpPort;

// Where nobody insists: the usual port instead, then any free one.
std::expected<std::unique_ptr<UdpPort>, hal::linux::OpenError> open_port(
    const Connections& wanted, OpenConnections& connections) {
  // Only a fixed destination is told that nobody listens there.
  const bool refusals = !wanted.to.empty();
  auto port = UdpPort::open(
      {.port = wanted.udp_port, .dscp = wanted.dscp, .streams = true, .refusals = refusals});
  if (port || wanted.port_required) {
    return port;
  }
  const std::string why = port.error().message;
  for (const std::uint16_t other : {Connections{}.udp_port, std::uint16_t{0}}) {
    port = UdpPort::open({.port = other, .streams = true, .refusals = refusals});
    if (port) {
      connections.other_port = true;
      connections.notes.push_back(why + "; port " + std::to_string((*port)->port()) + " instead");
      break;
    }
  }
  return port;
}

// What the system grants of what was asked for; empty: enough.
std::string small_buffer(const UdpPort& port) {
  const int asked = hal::linux::UdpPortOptions{}.buffer_bytes;
  if (port.streams_have_queues() || port.send_buffer() >= asked) {
    return {};
  }
  return "UDP port " + std::to_string(port.port()) + ": " + std::to_string(port.send_buffer()) +
         " bytes of buffer in place of " + std::to_string(asked) +
         ": receivers that vanish hold the others up; sysctl -w net.core.wmem_max=" +
         std::to_string(asked);
}

std::expected<hal::linux::SerialTty, std::string> open_serial(const Connections& wanted,
                                                              OpenConnections& connections) {
  const hal::linux::SerialOptions options{
      .device = wanted.serial, .baud = wanted.baud, .flow_control = wanted.flow_control};
  auto serial = hal::linux::SerialTty::open(options);
  if (serial || wanted.serial_required) {
    return serial;
  }
  connections.notes.push_back("waiting for the serial line: " + serial.error());
  return hal::linux::SerialTty::closed(options);
}

}  // namespace

std::expected<OpenConnections, Refusal> open_connections(const Connections& wanted) {
  OpenConnections connections;
  auto port = open_port(wanted, connections);
  if (!port) {
    return std::unexpected(Refusal{port.error().message});
  }
  connections.port = std::move(*port);
  if (std::string small = small_buffer(*connections.port); !small.empty()) {
    connections.notes.push_back(std::move(small));
  }
  // A socket of its own, which nobody reads: that of requests and streams must not reach all hosts.
  constexpr int kSmall = 1 << 14;
  auto beacon = UdpPort::open(
      {.buffer_bytes = kSmall, .ipv4_only = true, .dscp = wanted.dscp, .broadcast = true});
  if (beacon) {
    connections.beacon = std::move(*beacon);
  } else {
    connections.notes.push_back("no beacon: " + beacon.error().message);
  }
  if (!wanted.to.empty()) {
    const auto peer = hal::linux::resolve(wanted.to);
    if (!peer) {
      return std::unexpected(Refusal{peer.error().message});
    }
    if (hal::linux::is_broadcast(*peer)) {
      return std::unexpected(
          Refusal{"--to " + wanted.to + ": is an address of all hosts: give that of one"});
    }
    connections.to = *peer;
  }
  if (!wanted.serial.empty()) {
    auto serial = open_serial(wanted, connections);
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
