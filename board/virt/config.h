#pragma once

#include "board/config.h"

namespace stof::board {

// `qemu-system-aarch64 -M virt`: a PL061 for the trigger, cameras on USB. Everything is as on a
// real board but for time: an emulated processor is twenty times slower, so edges come five a
// second, and what is late by milliseconds is in time.
inline constexpr Config kConfig{
    .name = "virt",
    .stereo =
        {.width = 640, .height = 480, .disparities = 64, .block_width = 64, .block_height = 64},
    .pmd = {.width = 176, .height = 144},
    .timing = {.period = std::chrono::milliseconds(200),
               .stereo_exposure = std::chrono::milliseconds(4),
               .pmd_integration = std::chrono::milliseconds(16),
               .edge_tolerance = std::chrono::milliseconds(12),
               .pmd_every = 1},
    .devices = {.nets = {.left_trigger = {"CAM_L_TRIG", "9030000.pl061:0"},
                         .right_trigger = {"CAM_R_TRIG", "9030000.pl061:1"},
                         .pmd_trigger = {"PMD_TRIG", "9030000.pl061:2"},
                         .left_strobe = {"CAM_L_STROBE", ""},
                         .right_strobe = {"CAM_R_STROBE", ""},
                         .pair_button = {"PAIR_BUTTON", ""}},
                .v4l2 = {.left = "usb:1209:0051",
                         .right = "usb:1209:0052",
                         .pulse = std::chrono::microseconds(100),
                         .most_delay = std::chrono::milliseconds(180)},
                .libcamera = {.left = "1209:0051",
                              .right = "1209:0052",
                              .pulse = std::chrono::microseconds(100),
                              .most_delay = std::chrono::milliseconds(180)},
                .pmd = {.usb_vendor = 0x1209,
                        .usb_product = 0x0050,
                        .edge_tolerance = std::chrono::milliseconds(90)},
                .watchdog = "/dev/watchdog0",
                .watchdog_timeout = std::chrono::seconds(15),
                .priority = 45},
    .nominal = {.stereo_focal_px = 615,
                .baseline_m = 0.12,
                .pmd_focal_px = 158.8,
                .pmd_right_m = 0.06,
                .pmd_below_m = -0.04},
    .workspace_limit = 15U << 20,
};
static_assert(valid(kConfig));

}  // namespace stof::board
