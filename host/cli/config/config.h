#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include <CLI/CLI.hpp>

#include "host/client/control/control_client.h"

namespace stof::host {

struct ConfigOptions {
  std::vector<std::string> words{};  // [SENSOR] ACTION [ARGUMENT...]; no SENSOR with a serial line
  std::string sensor{};              // of `words`, once config() has read it
  std::string serial{};              // device; empty: over the network
  unsigned baud = 921'600;
  std::string document = "active";        // of get: active, staged, saved or defaults
  double timeout_s = 0.3;                 // of each of three attempts
  std::optional<std::uint32_t> device{};  // number of the sensor; none: whoever answers
  std::string key{};   // id of the key that alone counts; empty: of those that there are
  std::string keys{};  // file of this user's keys; empty: config() takes the usual one
  bool json = false;
};

// Adds `stof config` and its flags; it runs when the command line was parsed.
void add_config(CLI::App& app, ConfigOptions& options);

// `stof config`: reads or changes a sensor's settings, prints to stdout. Throws Failure.
void config(const ConfigOptions& options);

// The same over a transport that is open. words: ACTION [ARGUMENT...]. Returns what is printed.
std::string config_over(std::unique_ptr<client::ControlTransport> transport,
                        const std::vector<std::string>& words, const ConfigOptions& options);

}  // namespace stof::host
