#pragma once

#include "board/config.h"
#include "board/raspberry_pi.h"

namespace stof::board {

// Raspberry Pi 5 and Compute Module 5.
inline constexpr Config kConfig{
    .name = "rpi5",
    .stereo =
        {.width = 1280, .height = 720, .disparities = 128, .block_width = 64, .block_height = 64},
    .pmd = {.width = 224, .height = 172},
    .timing = kPiTiming,
    .devices = kPiDevices,
    .nominal = {.stereo_focal_px = 1230,
                .baseline_m = 0.12,
                .pmd_focal_px = 202,
                .pmd_right_m = 0.06,
                .pmd_below_m = -0.04},
    .workspace_limit = 44U << 20,
};
static_assert(valid(kConfig));

}  // namespace stof::board
