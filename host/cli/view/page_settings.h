#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "host/cli/config/config.h"
#include "host/viewer/panel_messages.h"

// The settings panel of the page: what `stof config` does, with the same keys.
namespace stof::host {

// The sensor that is shown.
struct ShownSensor {
  std::string address{};     // HOST[:PORT]; empty: nobody knows yet
  std::uint32_t device = 0;  // its number, as its frames say
  bool unpaired = false;     // it says so
  bool told = false;         // it has said how it is: both of the above are known
};

// Who this program is for it, by its keys: a role; "anybody": it is not paired; "none": it is, and
// no key is there. doubt: one line why none is used, or empty. Throws Failure.
struct OwnRole {
  std::string role;
  std::string doubt;
};
OwnRole own_role(const ShownSensor& sensor, const ConfigOptions& options);

// Its documents and schema, and who this program is for it. Blocks as long as its answers take; of
// what goes wrong the state has one line.
viewer::SettingsState read_settings(const ShownSensor& sensor, const ConfigOptions& options);

// Has it set these, "depth.max_range_mm=4000", all or none of them; or has it save what is active.
// One line: what it says. Throws Failure.
std::string change_settings(const ShownSensor& sensor, const ConfigOptions& options,
                            const std::vector<std::string>& assignments);
std::string save_settings(const ShownSensor& sensor, const ConfigOptions& options);

}  // namespace stof::host
