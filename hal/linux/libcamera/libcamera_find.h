#pragma once

#include <cstddef>
#include <expected>
#include <span>
#include <string>

#include "hal/linux/open_error.h"

namespace stof::hal::linux {

struct LibcameraName {
  std::string id;
  std::string model;
};

// Which of these cameras, sorted by id, is meant, as LibcameraOptions::left says. A part of an id
// goes before an expression. None, or several: an error that lists them.
std::expected<std::size_t, OpenError> find_libcamera(std::span<const LibcameraName> cameras,
                                                     const std::string& wanted);

}  // namespace stof::hal::linux
