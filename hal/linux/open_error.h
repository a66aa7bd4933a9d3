#pragma once

#include <string>

namespace stof::hal::linux {

// A device or destination that cannot be used: one line, what, where and what to do.
struct OpenError {
  std::string message;
};

}  // namespace stof::hal::linux
