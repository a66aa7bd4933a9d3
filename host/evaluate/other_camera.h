#pragma once

#include <string>

#include "dsp/calib/pmd_sensor.h"

// Whether a calibration can be of the camera that a recording is of. No calibration file holds a
// serial number: two cameras of one model are not told apart.
namespace stof::host {

// Empty, or the first that differs of modulation frequency, sample range and integration time;
// those count that both tell.
std::string other_camera(const dsp::PmdSensor& calibrated, const dsp::PmdSensor& recorded);

}  // namespace stof::host
