#pragma once

#include <string>

#include <CLI/CLI.hpp>

#include "host/cli/receive.h"
#include "host/cli/sensor/checks.h"

namespace stof::host {

struct CheckOptions : ReceiveOptions {
  double seconds = 3;
  bool json = false;
  std::string version{};  // of this program
};

// Subscribes for that long, and asks and listens beside. Never throws for want of frames: that is
// what the checks say. Throws Failure for bad input. look: sees each frame, may be empty.
CheckFacts check_sensor(const CheckOptions& options,
                        const std::function<void(const client::Frame&)>& look = {},
                        const std::function<void(const wire::EventReport&)>& event = {});
// What a recording tells. Throws Failure.
CheckFacts check_file(const CheckOptions& options);

// Adds `stof check`. version: of this program, such as "1.2.3".
void add_check(CLI::App& app, CheckOptions& options, const char* version);

}  // namespace stof::host
