#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <expected>
#include <memory>
#include <string>

#include "host/netem/impairment.h"

namespace stof::netem {

enum class Direction : std::uint8_t { kBoth, kDown, kUp };  // down: from upstream to a client

struct RelayOptions {
  std::string listen_address = "0.0.0.0";  // IPv4 or IPv6 literal
  std::uint16_t listen_port = 0;           // 0: any free one
  std::string upstream{};                  // HOST:PORT, an IPv6 literal in brackets
  ImpairmentOptions impairment{};
  Direction only = Direction::kBoth;  // what is impaired; the other passes as it is
};

struct RelayCounts {
  Impairment::Counts up;
  Impairment::Counts down;
  std::size_t clients = 0;  // now
};

// Passes datagrams between any number of clients (64 at once, each for a minute after its last
// datagram) and one upstream address. Each client has a socket of its own there, so that upstream
// tells them apart.
class Relay {
 public:
  // The error is one line for a person: what, where, what to do.
  static std::expected<std::unique_ptr<Relay>, std::string> open(const RelayOptions& options);
  virtual ~Relay() = default;

  // Passes what there is, for no longer than `timeout`. False: the listening socket failed.
  virtual bool run(Duration timeout) = 0;
  virtual std::uint16_t port() const = 0;
  virtual RelayCounts counts() const = 0;
};

}  // namespace stof::netem
