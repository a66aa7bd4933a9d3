#pragma once

#include <cstdint>
#include <expected>
#include <memory>
#include <string>

#include "host/client/control/control_client.h"

namespace stof::client {

inline constexpr std::uint16_t kLinkPort = 7561;  // where all that is told to a whole link arrives

// A sensor that has answered a discover by broadcast.
struct LinkTarget {
  std::uint32_t device_id = 0;
  std::uint32_t session_id = 0;
  std::uint16_t port = 0;  // of its requests
  std::string called{};    // for messages
};

// To a sensor near that has no address of a network of this machine: requests and answers go to all
// hosts of the links that this machine has (docs/WIRE.md, "By broadcast"). Nobody subscribes so.
// place() has a space, as no place has that is remembered. kDeviceError: there is no such socket.
std::expected<std::unique_ptr<ControlTransport>, ControlError> open_link_transport(
    const LinkTarget& target);

}  // namespace stof::client
