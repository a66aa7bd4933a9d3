#pragma once

#include "dataset/pmd_recording.h"
#include "dsp/calib/pmd_sensor.h"

// Frames of something that stands, added before they become distances: one frame of so many times
// the light. A mean of distances would be off by half the curvature of the wiggling times the
// variance of a reading: 1 to 3 mm where readings scatter by 7 to 12 cm (20 MHz, harmonics of an
// LED), and no number of frames makes that less.
namespace stof::host {

struct LongExposures {
  dataset::PmdRecording recording;  // of the first frequency alone
  dsp::PmdSensor sensor;            // whose samples these are
};

// As many frames in one as a sample has room for (dsp::PhaseKernel), all with as many; what is
// saturated or under range in one of them is that in the sum.
LongExposures lengthened(dataset::PmdRecording recording, const dsp::PmdSensor& sensor);

}  // namespace stof::host
