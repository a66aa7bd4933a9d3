#pragma once

namespace stof::host {

// Prints what converting a 176x144 PMD frame and fusing it at 640x480 takes (the emulated
// corridor), and the share of that in OpenCV's StereoBM, dense, 640x480 with 64 candidates, in the
// same run.
void compare_fusion();

}  // namespace stof::host
