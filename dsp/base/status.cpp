#include "dsp/base/status.h"

namespace stof {

const char* to_string(Status status) noexcept {
  switch (status) {
    case Status::kOk:
      return "ok";
    case Status::kTimeout:
      return "timeout";
    case Status::kWouldBlock:
      return "would block";
    case Status::kCorrupt:
      return "corrupt data";
    case Status::kDeviceLost:
      return "device lost";
    case Status::kDeviceError:
      return "device error";
    case Status::kInvalidArgument:
      return "invalid argument";
    case Status::kTooLarge:
      return "too large";
    case Status::kUnsupported:
      return "unsupported";
  }
  return "unknown status";
}

}  // namespace stof
