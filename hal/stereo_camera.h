#pragma once

#include <cstdint>

#include "dsp/base/image.h"
#include "dsp/base/status.h"
#include "hal/borrowed_frame.h"
#include "hal/time.h"

namespace stof::hal {

// Two 8-bit grey views of equal size: of cameras as they are where the calibration tells how to
// rectify them (dsp::RawPair), else rectified or adjusted so that rows correspond.
// The exposures are each sensor's own: whether they belong together is the caller's to check.
struct StereoFrame {
  dsp::ImageView<const std::uint8_t> left;
  dsp::ImageView<const std::uint8_t> right;
  Exposure left_exposure;
  Exposure right_exposure;
  std::uint32_t left_sequence = 0;  // of the sensor, advances by one with each exposure it made
  std::uint32_t right_sequence = 0;
};

class StereoCamera {
 public:
  virtual ~StereoCamera() = default;
  // The oldest frame that was not yet handed out. Blocks until there is one or the deadline passes.
  // kTimeout: none came. kCorrupt: one came damaged and was dropped. kDeviceLost: reopen.
  // Holds at least three slots: with two lent a third frame can still arrive; with all slots
  // out, frames are dropped.
  virtual Result<BorrowedFrame<StereoFrame>> wait_frame(Time deadline) noexcept = 0;
};

}  // namespace stof::hal
