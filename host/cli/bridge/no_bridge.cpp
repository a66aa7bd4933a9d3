#include "host/cli/bridge/bridge.h"
#include "host/cli/failure.h"
#include "host/cli/help_text.h"

namespace stof::host {

void add_bridge(CLI::App& app, BridgeOptions& /*options*/) {
  CLI::App& bridge = *app.add_subcommand("bridge", "Pass depth on as a robot's middleware has it");
  bridge.require_subcommand(1);
  CLI::App& ros2 = *bridge.add_subcommand("ros2", "Not in this build (scripts/setup bridge)");
  show_example(ros2, "stof bridge ros2 192.168.1.20 --namespace front");
  ros2.allow_extras();
  ros2.callback([] {
    throw Failure(
        Exit::kBadInput,
        "bridge ros2: this stof was built without it: run scripts/setup bridge, configure "
        "with -DSTOF_BRIDGE=ON, and build again");
  });
}

}  // namespace stof::host
