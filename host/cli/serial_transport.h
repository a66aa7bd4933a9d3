#pragma once

#include <expected>
#include <memory>
#include <string>

#include "host/client/control/control_client.h"

namespace stof::host {

// A serial line to a sensor: COBS frames, 8N1, any speed that the driver can make. Whatever else
// the line carries is passed on too; the client picks its answers out of it.
// kDeviceError: no such line, or not a line.
std::expected<std::unique_ptr<client::ControlTransport>, client::ControlError>
open_serial_transport(const std::string& device, unsigned baud);

}  // namespace stof::host
