#pragma once

#include <string>

#include "dsp/base/status.h"

namespace stof::client {

// One line for a person: what, where, what to do.
struct OpenError {
  Status status;
  std::string message;
};

}  // namespace stof::client
