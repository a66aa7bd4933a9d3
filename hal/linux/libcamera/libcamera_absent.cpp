#include "hal/linux/libcamera/libcamera_stereo.h"

namespace stof::hal::linux {

std::expected<std::unique_ptr<ReopenableStereo>, OpenError> open_libcamera(
    const LibcameraOptions& /*options*/) {
  return std::unexpected(
      OpenError{"this stofd was built without libcamera: use stofd-libcamera, or --cameras v4l2"});
}

}  // namespace stof::hal::linux
