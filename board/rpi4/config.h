#pragma once

#include "board/config.h"

namespace stof::board {

// Raspberry Pi 4 and Compute Module 4. Net names as in docs/HARDWARE.md, lines as the kernel calls
// those of pinctrl-bcm2711.
inline constexpr Config kConfig{
    .name = "rpi4",
    .stereo =
        {.width = 640, .height = 480, .disparities = 64, .block_width = 64, .block_height = 64},
    .pmd = {.width = 176, .height = 144},
    .timing = {.period = std::chrono::microseconds(33'333),
               .stereo_exposure = std::chrono::milliseconds(4),
               .pmd_integration = std::chrono::milliseconds(16),
               .edge_tolerance = std::chrono::microseconds(200),
               .pmd_every = 1},
    .devices = {.nets = {.left_trigger = {"CAM_L_TRIG", "GPIO17"},
                         .right_trigger = {"CAM_R_TRIG", "GPIO27"},
                         .pmd_trigger = {"PMD_TRIG", "GPIO22"},
                         .left_strobe = {"CAM_L_STROBE", ""},
                         .right_strobe = {"CAM_R_STROBE", ""}},
                // Triggered UVC cameras of a global shutter: a rising edge begins the exposure.
                .v4l2 = {.left = "usb:1209:0051",
                         .right = "usb:1209:0052",
                         .pulse = std::chrono::microseconds(100),
                         .most_delay = std::chrono::milliseconds(25)},
                // IMX296 through XTR: it exposes while XTR is low, and 14.26 us on (Raspberry Pi
                // documentation, external trigger).
                .libcamera = {.left = "model:imx296:0",
                              .right = "model:imx296:1",
                              .active_low = true,
                              .pulse_lag = std::chrono::nanoseconds(14'260),
                              .most_delay = std::chrono::milliseconds(20)},
                .pmd = {.usb_vendor = 0x1209, .usb_product = 0x0050},
                .watchdog = "/dev/watchdog0",
                .watchdog_timeout = std::chrono::seconds(15),  // the longest of a BCM2835
                .priority = 45},
    .drawn = {.stereo_focal_px = 615,
              .baseline_m = 0.12,
              .pmd_focal_px = 158.8,
              .pmd_right_m = 0.06,
              .pmd_below_m = -0.04},
    .workspace_limit = 24U << 20,
};
static_assert(valid(kConfig));

}  // namespace stof::board
