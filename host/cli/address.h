#pragma once

#include <string>
#include <vector>

#include <CLI/CLI.hpp>

#include "host/cli/control_flags.h"

// `stof address`: where a sensor is on the network, changed so that nobody loses it.
namespace stof::host {

struct AddressOptions : ControlFlags {
  std::vector<std::string> words{};  // [SENSOR] ADDRESS...; no SENSOR with `serial`
  std::string gateway{};
  double wait_s = 45;  // to hear it at its new address
  bool json = false;
};

// What the words ask for: settings network.* as the sensor takes them.
struct AddressWish {
  bool dhcp = false;
  bool link_local = false;  // alone
  std::string address{};    // with the bits of its network; empty: none that is fixed
  std::string gateway{};

  std::string settings() const;  // a JSON object
};
// words: ADDRESS/BITS, dhcp or both; or link-local. Throws Failure, bad input.
AddressWish address_wish(const std::vector<std::string>& words, const std::string& gateway);

void add_address(CLI::App& app, AddressOptions& options);

// Sets it, waits until the sensor is heard there, and saves. Who is not heard goes back by itself.
// Throws Failure.
void set_address(const AddressOptions& options);

}  // namespace stof::host
