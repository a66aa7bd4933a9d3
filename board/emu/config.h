#pragma once

#include "board/config.h"

namespace stof::board {

// The emulated rig: any laptop, no device. Sized for 1280x720 with 128 disparities.
inline constexpr Config kConfig{
    .name = "emu",
    .stereo =
        {.width = 1280, .height = 720, .disparities = 128, .block_width = 64, .block_height = 64},
    .pmd = {.width = 640, .height = 480},
    .timing = {.period = std::chrono::microseconds(33'333),
               .stereo_exposure = std::chrono::milliseconds(4),
               .pmd_integration = std::chrono::milliseconds(16),
               .edge_tolerance = std::chrono::microseconds(200),
               .pmd_every = 1},
    .workspace_limit = 74U << 20,  // mostly a PMD camera as large as its test recordings
};
static_assert(valid(kConfig));

}  // namespace stof::board
