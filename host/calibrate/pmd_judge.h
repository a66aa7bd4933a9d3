#pragma once

#include "host/calibrate/walls/pmd_wall.h"

// A calibration against the wall that it should see: through the appliance's own converter.
namespace stof::host {

struct WallScore {
  double z_m = 0;
  // Of the middle of the picture, over all frames and pixels that carry a distance. NaN: none does.
  double error_m = 0;      // mean of Z less the wall's
  double spread_m = 0;     // temporal, of the radial distance, pooled over pixels; NaN: one frame
  double predicted_m = 0;  // sigma that the converter says, pooled alike
  double valid = 0;        // share of the readings in the middle that carry a distance
};

// Over the chosen frames. The sensor has the recording's size.
WallScore judge(const dsp::PmdSensor& sensor, const WallRecording& wall, Frames frames);

}  // namespace stof::host
