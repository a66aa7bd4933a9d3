#pragma once

#include <cstdint>
#include <filesystem>
#include <string>

#include <CLI/CLI.hpp>

#include "host/client/sensor_socket.h"

namespace stof::host {

struct ReplayOptions {
  std::filesystem::path file;
  double rate = 1;    // 2: twice as fast as it was
  bool loop = false;  // from the begin again, until interrupted
  std::uint16_t port = client::kDefaultPort;
  std::string bind = "127.0.0.1";
  std::filesystem::path port_file;
  double timeout_s = 0;  // for the first subscriber; 0: until interrupted
  bool json = false;
};

// Adds `stof replay` and its flags; it runs when the command line was parsed.
void add_replay(CLI::App& app, ReplayOptions& options);

// `stof replay`: sends a recording to whoever subscribes, as a sensor would. Throws Failure.
void replay(const ReplayOptions& options);

}  // namespace stof::host
