#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include <CLI/CLI.hpp>

#include "host/cli/control_flags.h"
#include "host/client/control/control_client.h"

namespace stof::host {

// For help and completion.
inline constexpr const char* kConfigActions =
    "get set stage commit revert preset save reset diff schema";
inline constexpr const char* kPresetNames = "indoor outdoor near fast quality";

struct ConfigOptions : ControlFlags {
  std::vector<std::string> words{};  // [SENSOR] ACTION [ARGUMENT...]; no SENSOR with a serial line
  std::string sensor{};              // of `words`, once config() has read it
  std::string document = "active";   // of get: active, staged, saved or defaults
  bool json = false;
  bool may_save = true;  // false: what is in force until the next start is not told to be saved
};

// Adds `stof config` and its flags; it runs when the command line was parsed.
void add_config(CLI::App& app, ConfigOptions& options);

// `stof config`: reads or changes a sensor's settings, prints to stdout. Throws Failure.
void config(const ConfigOptions& options);

// The same over a transport that is open. words: ACTION [ARGUMENT...]. Returns what is printed.
std::string config_over(std::unique_ptr<client::ControlTransport> transport,
                        const std::vector<std::string>& words, const ConfigOptions& options);

}  // namespace stof::host
