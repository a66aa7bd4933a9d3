#pragma once

#include "board/config.h"

// The common part of boards with a Raspberry Pi's 40-pin header. Net names as in docs/HARDWARE.md,
// lines as the kernel calls those of pinctrl-bcm2711 and of RP1.
namespace stof::board {

inline constexpr TimingConfig kPiTiming{.period = std::chrono::microseconds(33'333),
                                        .stereo_exposure = std::chrono::milliseconds(4),
                                        .pmd_integration = std::chrono::milliseconds(16),
                                        .edge_tolerance = std::chrono::microseconds(200),
                                        .pmd_every = 1};

inline constexpr DeviceConfig kPiDevices{
    .nets = {.left_trigger = {"CAM_L_TRIG", "GPIO17"},
             .right_trigger = {"CAM_R_TRIG", "GPIO27"},
             .pmd_trigger = {"PMD_TRIG", "GPIO22"},
             .left_strobe = {"CAM_L_STROBE", ""},
             .right_strobe = {"CAM_R_STROBE", ""},
             .pair_button = {"PAIR_BUTTON", "GPIO25"}},
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
    .priority = 45};

}  // namespace stof::board
