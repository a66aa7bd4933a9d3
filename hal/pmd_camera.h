#pragma once

#include <array>
#include <cstdint>

#include "dsp/base/image.h"
#include "dsp/base/status.h"
#include "hal/borrowed_frame.h"
#include "hal/time.h"

namespace stof::hal {

// Four samples A0..A3 of equal size: correlation at reference phase k * 90 degrees, u16 with 10..15
// bits used. They are taken one after the other; each carries its own exposure.
struct PmdFrame {
  std::array<dsp::ImageView<const std::uint16_t>, 4> samples;
  std::array<Exposure, 4> exposures;
  std::uint32_t sequence = 0;  // of the sensor, advances by one with each set it made
};

class PmdCamera {
 public:
  virtual ~PmdCamera() = default;
  // As StereoCamera::wait_frame.
  virtual Result<BorrowedFrame<PmdFrame>> wait_frame(Time deadline) noexcept = 0;
};

}  // namespace stof::hal
