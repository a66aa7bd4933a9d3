#pragma once

#include <expected>
#include <string>

#include "host/client/control/control_client.h"

namespace stof::client {

// The bytes of the calibration file that a sensor runs with (docs/WIRE.md, "Downloads"), compared
// with its fingerprint; blocks, a part a request. Errors as ControlClient::request(); kUnsupported:
// the sensor is older than downloads, or cannot give it; kCorrupt: its answers contradict
// themselves.
std::expected<std::string, ControlError> download_calibration(ControlClient& client);

}  // namespace stof::client
