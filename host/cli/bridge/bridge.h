#pragma once

#include <cstdint>
#include <filesystem>
#include <string>

#include <CLI/CLI.hpp>

#include "host/cli/receive.h"

// `stof bridge ros2`: a component of its own, which needs the package of `scripts/setup bridge`.
// Built without, the command says so.
namespace stof::host {

struct BridgeOptions : ReceiveOptions {
  std::string name_space = "stof";
  std::uint32_t domain = 0;
  unsigned fragment = 1344;       // bytes
  unsigned datagram = 14'720;     // bytes
  int cloud_step = 4;             // 0: no cloud
  std::string mount{};            // PARENT:X,Y,Z[,ROLL,PITCH,YAW]; empty: not told
  bool loop = false;              // of a recording
  std::filesystem::path times{};  // empty: none
};

// Adds `stof bridge` with its command; it runs when the command line was parsed.
void add_bridge(CLI::App& app, BridgeOptions& options);

}  // namespace stof::host
