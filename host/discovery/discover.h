#pragma once

#include <chrono>
#include <cstdint>
#include <expected>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "host/discovery/found_sensors.h"

namespace stof::client {

inline constexpr std::uint16_t kSensorPort = 7560;  // of requests
inline constexpr std::uint16_t kBeaconPort = 7561;  // and of answers to all of a link

struct DiscoverOptions {
  // A beacon comes once a second, answers within milliseconds.
  std::chrono::milliseconds timeout{2500};
  // HOST[:PORT], IPv6 with a port in brackets: asked beside all that are near.
  std::vector<std::string> addresses{};
  // Who is looked for, of sensors that have answered themselves: kGrace after the first one the
  // search is over. Empty: it takes the whole timeout.
  std::function<bool(const FoundSensor&)> wanted{};
  static constexpr std::chrono::milliseconds kGrace{300};  // for a second one of that kind
};

// One line for a person.
struct DiscoverError {
  std::string message;
};

// Asks for sensors by broadcast, also so that those are heard which have no address of a network of
// this machine; by IPv6, on this machine, at the given addresses and by multicast DNS; and listens
// to beacons, for the timeout. Blocks for it, and before that on a name server. The
// error: an address that is none, or no socket at all; a network that is missing is none.
std::expected<std::vector<FoundSensor>, DiscoverError> discover(const DiscoverOptions& options);

// Asks the one at an address, HOST[:PORT], who it is, four times within the timeout; `device`: no
// other sensor's answer counts. The error: not an address, no such host, or no answer. May block on
// a name server.
std::expected<FoundSensor, DiscoverError> ask_sensor(
    const std::string& address, std::chrono::milliseconds timeout,
    std::optional<std::uint32_t> device = std::nullopt);

}  // namespace stof::client
