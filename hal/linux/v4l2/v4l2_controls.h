#pragma once

#include <cstdint>
#include <expected>
#include <optional>
#include <string>

#include "hal/linux/v4l2/v4l2_calls.h"
#include "hal/time.h"

// Exposure and gain of an open V4L2 device. An error is the end of a line: why and what to do.
namespace stof::hal::linux {

// Exposes by hand for `exposure`, in the units of V4L2_CID_EXPOSURE_ABSOLUTE, 100 us, at a rate
// that does not follow the light. Returns the driver's value, at most a step away; nullopt: the
// device has no such control, as sensors behind a bridge.
std::expected<std::optional<Duration>, std::string> set_v4l2_exposure(V4l2Calls& calls, int fd,
                                                                      Duration exposure);

// In the driver's units. Without such a control nothing happens.
std::expected<void, std::string> set_v4l2_gain(V4l2Calls& calls, int fd, std::int32_t gain);

}  // namespace stof::hal::linux
