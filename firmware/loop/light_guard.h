#pragma once

#include <cstdint>

#include "dsp/calib/pmd_sensor.h"
#include "hal/pmd_camera.h"

namespace stof::firmware {

// Tells when the light of a PMD camera's lamp goes out: an eighth of the pixels or more had light,
// and in the next frame one in 256 has at most. What turns away from everything within its reach
// loses light little by little; such a frame is no failure. It looks at every fourth row.
//
// A pixel has light where twice its amplitude is above that of the sensor's least amplitude, and
// its square above 40 times the variance of a sample, which noise exceeds once in 20,000 pixels.
class LightGuard {
 public:
  explicit LightGuard(const dsp::PmdSensor& sensor) noexcept;

  // Whether the light has gone, and has not come back yet.
  bool gone(const hal::PmdFrame& frame) noexcept;

 private:
  std::int64_t least_square_;  // of twice the amplitude
  // 40 times the variance without light, less what the dark level adds to the next; and that of
  // light, for each LSB of the sum of four samples
  std::int64_t noise_q16_;
  std::int64_t shot_q16_;
  bool was_lit_ = false;  // the last frame that had light had much
};

}  // namespace stof::firmware
