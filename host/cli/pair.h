#pragma once

#include <string>

#include <CLI/CLI.hpp>

#include "host/cli/control_flags.h"

namespace stof::host {

struct PairOptions : ControlFlags {
  std::string sensor{};  // HOST[:PORT]; empty with `serial` or `into`
  std::string code{};    // of the label; empty: six digits are compared
  bool renew = false;    // the key that there is gets a new secret
  std::string digits{};  // that the sensor told; empty: asked for
  bool window = false;   // over the cable: lets somebody else pair with digits
  std::string into{};    // key file of a sensor that does not run
  bool again = false;    // also a sensor whose number another key has
  std::string role = "admin";
  std::string name{};  // whose key it is; empty: USER@HOST
  bool json = false;
};

struct UnpairOptions : ControlFlags {
  std::string sensor{};
  std::string id{};     // of the key; empty: this user's own
  bool list = false;    // says which keys there are
  bool forget = false;  // in this user's file alone: the sensor is gone
  bool json = false;
};

// Adds `stof pair`, `stof unpair` and their flags; they run when the command line was parsed.
void add_pair(CLI::App& app, PairOptions& options, UnpairOptions& unpairing);

// `stof pair`: makes a key that a sensor and this user share, or lets somebody else do it. Throws
// Failure.
void pair(const PairOptions& options);
// `stof unpair`: ends one, or lists them. Throws Failure.
void unpair(const UnpairOptions& options);

}  // namespace stof::host
