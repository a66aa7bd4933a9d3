#pragma once

#include <cstdint>
#include <optional>
#include <string>

namespace stof::host {

// What this machine knows of its own end of the way to a sensor. What the system does not tell is
// absent.
struct NetworkFacts {
  std::string interface{};  // that packets leave by, such as eth0; empty: not known
  bool loopback = false;
  std::optional<int> mtu{};                  // bytes of an IP packet
  std::optional<int> speed_mbit{};           // of the cable; radio and virtual links tell none
  std::optional<int> most_buffer{};          // net.core.rmem_max, bytes
  std::optional<bool> clock_synchronised{};  // this machine's wall clock
};

// fd: a socket that is connected to the sensor.
NetworkFacts network_facts(int fd);

// Whether this machine refuses to send there by a rule of its own firewall. address: HOST[:PORT].
bool sending_is_refused(const std::string& address);

}  // namespace stof::host
