#pragma once

#include "firmware/control/access.h"
#include "firmware/settings/text/paged_writer.h"
#include "firmware/wire/messages/enums.h"
#include "hal/network_interfaces.h"

namespace stof::settings {

// Document network: which IPv4 addresses this computer has, but for loopback. Whoever is answered
// at another one is answered by somebody between. interfaces: nullptr: there is nothing to tell.
wire::SettingsResult write_network(hal::NetworkInterfaces* interfaces, firmware::Access access,
                                   PagedWriter& out) noexcept;

}  // namespace stof::settings
