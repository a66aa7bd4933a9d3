#pragma once

#include "host/bridge/topics.h"
#include "host/cli/bridge/bridge.h"

namespace stof::host {

// Until a signal comes, or a recording is over. Throws Failure.
void bridge_ros2(const BridgeOptions& options, const bridge::Mount& mount);

}  // namespace stof::host
