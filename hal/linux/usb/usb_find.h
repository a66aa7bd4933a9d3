#pragma once

#include <cstdint>
#include <expected>
#include <string>

#include "hal/linux/open_error.h"

namespace stof::hal::linux {

struct UsbId {
  std::uint16_t vendor = 0;
  std::uint16_t product = 0;
  std::string serial;  // as the device tells it (iSerialNumber); empty: any
};

// Where the system keeps its devices.
struct UsbRoots {
  std::string devices = "/sys/bus/usb/devices";
  std::string nodes = "/dev/bus/usb";
};

// The node of the one device that is plugged in with this id, such as /dev/bus/usb/001/004. An
// error is one line: none is there, or several are. Allocates; reads files of the system.
std::expected<std::string, OpenError> find_usb(const UsbId& id, const UsbRoots& roots = {});
// "1209:0050", with the serial number if there is one.
std::string to_string(const UsbId& id);

}  // namespace stof::hal::linux
