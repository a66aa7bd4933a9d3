#pragma once

#include <array>

#include "host/calibrate/fit/pmd_model.h"
#include "host/calibrate/walls/pmd_wall.h"

// One recording of a wall through the appliance's own converter, against the wall that it should
// see.
namespace stof::host {

inline constexpr std::size_t kPmdFlags = 8;  // bits of PmdFlag

// Errors are of Z; shares, means and sigmas are of the readings in the middle of the picture
// (middle_of). Maps are means over the frames; NaN where no frame carries a distance.
struct WallView {
  double error_m = 0;      // mean of Z less the wall's; NaN: no reading carries a distance
  double spread_m = 0;     // temporal, of the radial distance, pooled over pixels; NaN: one frame
  double predicted_m = 0;  // sigma that the converter says, pooled alike
  double valid = 0;        // share of the readings that carry a distance
  std::array<double, kPmdFlags> flagged{};
  double ratio = 0;  // mean modulation ratio
  double amp2 = 0;
  dataset::Image<float> z_m;
  dataset::Image<float> modulation;
  dataset::Image<float> valid_share;  // of the frames
};

// Over the chosen frames. The sensor has the recording's size; its stray and suppressed light grow
// with the recording's exposure. `turn`: how the wall stands.
WallView view_wall(const dsp::PmdSensor& sensor, const WallRecording& wall, Frames frames,
                   const WallTurn& turn = {});

}  // namespace stof::host
