#pragma once

#include "board/devices/device_options.h"
#include "dsp/calib/calibration.h"

namespace stof::board {

// The rig as it is drawn, with pictures of these sizes (0x0: no PMD camera): lenses that
// scale with their pictures' width, without distortion, all axes parallel.
dsp::Calibration nominal_rig(const Config& config, PictureSize stereo, PictureSize pmd) noexcept;

}  // namespace stof::board
