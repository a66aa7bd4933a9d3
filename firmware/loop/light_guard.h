#pragma once

#include <cstdint>

#include "dsp/calib/pmd_sensor.h"
#include "hal/pmd_camera.h"

namespace stof::firmware {

// Tells whether the samples of a PMD camera hold light of its lamp. Those of a dark lamp, or of a
// scene with nothing within reach, are noise, which must not become distances. It looks at up to 72
// rows, at each frame by itself: a lamp that is dark from the start is no different.
//
// A pixel is lit where twice its amplitude, with and without the stray light of the calibration,
// is above that of the sensor's least amplitude, and its square above 40 times the variance of a
// sample, which noise exceeds once in 20,000 pixels, and its modulation ratio at least half of what
// a reading must have. A frame is lit where more than one pixel in 256 is, in one in 128 where the
// frame before was not.
//
// The variance is the calibration's, but for what the frame itself contradicts: A0 + A2 - A1 - A3
// is noise whatever the phase. Where half of the pixels have more of it than 1.5 times that
// variance explains, the variance is taken for 4, 16, 64 or 256 times as large. Motion
// raises it as well, but not to what the lamp gives. What ambient light changes by from sample to
// sample has an amplitude, too, but seldom such a share of that light.
class LightGuard {
 public:
  explicit LightGuard(const dsp::PmdSensor& sensor) noexcept;

  // Frames at the reference integration time.
  bool is_lit(const hal::PmdFrame& frame) noexcept;

  // Pixels that were looked at, and those of them that are lit.
  struct Count {
    int lit = 0;
    int all = 0;
  };
  Count count(const hal::PmdFrame& frame) const noexcept;

 private:
  std::int64_t least_square_;  // of twice the amplitude
  // 40 times the variance without light, less what the dark level adds to the next; and that of
  // light, for each LSB of the sum of four samples
  std::int64_t noise_q16_;
  std::int64_t shot_q16_;
  int four_dark_;  // LSB
  int ratio_q8_;   // twice the least modulation ratio that counts as light
  int stray_i_;    // LSB
  int stray_q_;
  bool was_lit_ = false;
};

}  // namespace stof::firmware
