#pragma once

#include <expected>
#include <string>

#include "hal/linux/open_error.h"
#include "hal/linux/v4l2/v4l2_calls.h"

namespace stof::hal::linux {

// The capture node (/dev/video0) that a text means:
//   /dev/video0             that node
//   usb:VVVV:PPPP           the camera of that USB vendor and product, four hexadecimal digits each
//   usb:VVVV:PPPP:SERIAL    the one of these with that serial number
//   card:NAME               the camera that calls itself so
// Nodes are looked for in `sysfs`/class/video4linux; those that do not capture and stream
// (metadata) are passed over. Two cameras of one text are an error.
std::expected<std::string, OpenError> find_v4l2_node(V4l2Calls& calls, const std::string& text,
                                                     const std::string& sysfs);

}  // namespace stof::hal::linux
