#include "host/cli/bridge/bridge.h"
#include "host/cli/failure.h"

namespace stof::host {

void add_bridge(CLI::App& app, BridgeOptions& /*options*/) {
  CLI::App& bridge = *app.add_subcommand("bridge", "Not in this build (scripts/setup bridge)");
  bridge.allow_extras();
  bridge.callback([] {
    throw Failure(Exit::kBadInput,
                  "bridge: this stof was built without it: run scripts/setup bridge, configure "
                  "with -DSTOF_BRIDGE=ON, and build again");
  });
}

}  // namespace stof::host
