#pragma once

#include <cstdint>
#include <optional>
#include <string>

#include <CLI/CLI.hpp>

namespace stof::host {

struct PairOptions {
  std::string sensor{};  // HOST[:PORT]; empty with `serial` or `into`
  std::string serial{};  // device; empty: over the network
  unsigned baud = 921'600;
  std::string code{};                     // of the label; empty: six digits are compared
  bool renew = false;                     // the key that there is gets a new secret
  std::string digits{};                   // that the sensor told; empty: asked for
  bool window = false;                    // over the cable: lets somebody else pair with digits
  std::string into{};                     // key file of a sensor that does not run
  std::optional<std::uint32_t> device{};  // number of the sensor; none: who is known there
  std::string key{};                      // id of the key to renew; empty: of those there are
  bool again = false;                     // also a sensor whose number another key has
  std::string role = "admin";
  std::string name{};      // whose key it is; empty: USER@HOST
  std::string keys{};      // this user's; empty: the usual one
  double timeout_s = 0.3;  // of each of three attempts
};

struct UnpairOptions {
  std::string sensor{};
  std::string serial{};
  unsigned baud = 921'600;
  std::string id{};     // of the key; empty: this user's own
  bool list = false;    // says which keys there are
  bool forget = false;  // in this user's file alone: the sensor is gone
  std::optional<std::uint32_t> device{};
  std::string key{};  // id of the one that signs; empty: of those there are
  std::string keys{};
  double timeout_s = 0.3;
};

// Adds `stof pair`, `stof unpair` and their flags; they run when the command line was parsed.
void add_pair(CLI::App& app, PairOptions& options, UnpairOptions& unpairing);

// `stof pair`: makes a key that a sensor and this user share, or lets somebody else do it. Throws
// Failure.
void pair(const PairOptions& options);
// `stof unpair`: ends one, or lists them. Throws Failure.
void unpair(const UnpairOptions& options);

}  // namespace stof::host
