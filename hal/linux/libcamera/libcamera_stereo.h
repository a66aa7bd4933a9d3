#pragma once

#include <expected>
#include <memory>
#include <string>

#include "hal/linux/camera/exposures.h"
#include "hal/linux/open_error.h"
#include "hal/stereo_camera.h"

namespace stof::hal::linux {

struct LibcameraOptions {
  // Which of libcamera's cameras (`cam -l`): a part of its id, a POSIX extended regular expression
  // that finds it, or "model:imx296:0": of the cameras of that model the first by id.
  std::string left;
  std::string right;
  int width = 0;  // pixels, of both
  int height = 0;
  // One of R8, YUV420, NV12, R10, R12, R16 (the latter three unpacked); empty: the first of these
  // that the camera has in this size.
  std::string format;
  int buffers =
      6;  // asked of each camera, 4 to 16; the uvcvideo pipeline gives 4 whatever is asked
  // Equal for both; set where the camera has the control. Zero: left to the camera.
  Duration exposure{0};
  Duration period{0};  // from frame to frame; with an external trigger longer than any pause
  float gain = 0;      // analogue, a factor
  // The exposures that stamps belong to; must outlive the camera. Null: the cameras run freely, and
  // the exposure is `exposure` long and ends at the stamp.
  Exposures* exposures = nullptr;
  Duration most_delay{0};  // from the end of an exposure to its stamp; frames beyond are dropped
  Duration most_skew{0};   // between the begins of two exposures that are one pair
};

// A stereo camera that can be opened again, in place. Frames that are lent stay readable.
class ReopenableStereo : public StereoCamera {
 public:
  // Blocks until the cameras run, seconds at worst, and allocates. kDeviceLost: not back yet.
  virtual Status reopen() noexcept = 0;
};

// Two cameras of libcamera. One at a time in a process: libcamera has one camera manager. Its
// thread runs beside the loop's; the calls that allocate on the loop's thread are those that give a
// buffer back (libcamera_stream.h). It writes no messages, unless the environment has
// LIBCAMERA_LOG_LEVELS. In a build without libcamera always an error.
std::expected<std::unique_ptr<ReopenableStereo>, OpenError> open_libcamera(
    const LibcameraOptions& options);

}  // namespace stof::hal::linux
