#pragma once

#include <cstdint>
#include <optional>
#include <string>

#include <CLI/CLI.hpp>

namespace stof::host {

// How commands that ask a sensor for something reach it, and with which key: `stof config`, `stof
// pair`, `stof unpair`, `stof calib install`.
struct ControlFlags {
  std::string serial{};                   // device; empty: over the network
  unsigned baud = 921'600;                // of it, bit/s
  std::optional<std::uint32_t> device{};  // number of the sensor; none: who is known there
  std::string key{};       // id of the key that alone counts; empty: of those that there are
  std::string keys{};      // file of this user's keys; empty: the usual one
  double timeout_s = 0.3;  // of each of three attempts
};

// --device, the number of the sensor that alone is believed.
void add_device_flag(CLI::App& command, std::optional<std::uint32_t>& device);

void add_control_flags(CLI::App& command, ControlFlags& flags);

}  // namespace stof::host
