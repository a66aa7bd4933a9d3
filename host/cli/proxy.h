#pragma once

#include <cstdint>
#include <filesystem>
#include <string>

#include <CLI/CLI.hpp>

// `stof proxy`: a bad network between a sensor and its receivers, on purpose.
namespace stof::host {

struct ProxyOptions {
  std::string bind = "0.0.0.0";
  std::uint16_t port = 0;
  std::string to;  // HOST:PORT of the sensor
  double loss_percent = 0;
  double burst = 1;
  double duplicate_percent = 0;
  double corrupt_percent = 0;
  int reorder = 0;
  double delay_ms = 0;
  double jitter_ms = 0;
  std::uint64_t seed = 1;
  std::string only = "both";
  std::filesystem::path port_file;  // gets the port's number when it is open
  bool json = false;                // the lines are objects
};

// Adds the command and its flags; it runs when the command line was parsed.
void add_proxy(CLI::App& app, ProxyOptions& options);

// Passes datagrams until SIGINT or SIGTERM, prints a line a second. Throws Failure.
void proxy(const ProxyOptions& options);

}  // namespace stof::host
