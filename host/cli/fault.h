#pragma once

#include <string>
#include <string_view>
#include <vector>

#include <CLI/CLI.hpp>

// Faults of an emulated sensor while it runs: what `stofd --fault-socket PATH` takes.
namespace stof::host {

// What a device may have, for completion.
inline constexpr const char* kFaultKinds =
    "none drop delay repeat tear corrupt vanish freeze dark hang";

// A device of the emulated rig.
struct DeviceFaults {
  std::string device{};              // trigger, stereo or pmd
  std::string now{};                 // the kind that it has; "none"
  std::string edges{};               // for how many more; "-": until it is ended, or none
  std::vector<std::string> kinds{};  // all that it can have
};

// Asks the sensor whose socket this is. order: "stereo:vanish:30", "stereo:none", "list"
// (board/emu/fault_orders.h). Waits for a second at most. Throws Failure: nobody answers, or it is
// refused.
std::vector<DeviceFaults> order_fault(const std::string& socket, std::string_view order);

struct FaultOptions {
  std::string socket{};
  std::vector<std::string> orders{};  // none: only says what there is
  bool json = false;
};

// Adds `stof fault` and its flags; it runs when the command line was parsed.
void add_fault(CLI::App& app, FaultOptions& options);

}  // namespace stof::host
