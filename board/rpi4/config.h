#pragma once

#include "board/config.h"
#include "board/raspberry_pi.h"

namespace stof::board {

// Raspberry Pi 4 and Compute Module 4.
inline constexpr Config kConfig{
    .name = "rpi4",
    .stereo =
        {.width = 640, .height = 480, .disparities = 64, .block_width = 64, .block_height = 64},
    .pmd = {.width = 176, .height = 144},
    .timing = kPiTiming,
    .devices = kPiDevices,
    .nominal = {.stereo_focal_px = 615,
                .baseline_m = 0.12,
                .pmd_focal_px = 158.8,
                .pmd_right_m = 0.06,
                .pmd_below_m = -0.04},
    .workspace_limit = 15U << 20,
};
static_assert(valid(kConfig));

}  // namespace stof::board
