#pragma once

#include <string>
#include <vector>

#include <CLI/CLI.hpp>

#include "host/discovery/found_sensors.h"

namespace stof::host {

struct DiscoverCommand {
  double timeout_s = 2.5;
  std::vector<std::string> addresses;  // HOST[:PORT]
  bool json = false;
};

// One line a sensor, as `stof discover` prints it.
std::string discover_line(const client::FoundSensor& sensor);
// One that two sensors answer as: which, and what to do.
std::string rival_text(const client::FoundSensor& sensor);
// All of them as a JSON array.
std::string discover_json(const std::vector<client::FoundSensor>& sensors);
// Says on stderr where so many were found that some may be missing.
void say_flood(std::size_t sensors);

// `stof discover`: lists the sensors near. Throws Failure, also where there is none.
void discover(const DiscoverCommand& command);

void add_discover(CLI::App& app, DiscoverCommand& command);

}  // namespace stof::host
