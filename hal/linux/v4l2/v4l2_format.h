#pragma once

#include <cstddef>
#include <expected>
#include <span>
#include <string>

#include "hal/linux/v4l2/grey_formats.h"
#include "hal/linux/v4l2/v4l2_calls.h"

namespace stof::hal::linux {

struct V4l2Format {
  FourCc pixels = 0;
  std::size_t stride = 0;  // bytes from one row to the next
};

// Sets pictures of width x height in the first of `formats` that the device has in that size. An
// error is the end of a line that names what it has.
std::expected<V4l2Format, std::string> set_v4l2_format(V4l2Calls& calls, int fd, int width,
                                                       int height, std::span<const FourCc> formats);

}  // namespace stof::hal::linux
