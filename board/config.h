#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>

#include "board/timing.h"
#include "hal/time.h"

namespace stof::board {

// One constexpr table per board, in the schematic's words. Sizes are the largest the board accepts:
// they size the static workspace.
struct StereoConfig {
  int width = 0;
  int height = 0;
  int disparities = 0;
  int block_width = 0;
  int block_height = 0;
};

struct PmdConfig {
  int width = 0;
  int height = 0;
};

// A net of the schematic, and the GPIO line that it is on: the kernel's name of the line
// ("GPIO17"), or LABEL:OFFSET on a chip whose lines have no names ("9030000.pl061:0"). Without a
// line it is not wired.
struct Net {
  const char* name = "";
  const char* line = "";
  constexpr bool wired() const noexcept { return *line != '\0'; }
};

// From the board to the trigger inputs of the cameras, and what left and right camera answer while
// they expose.
struct Nets {
  Net left_trigger{};
  Net right_trigger{};  // not wired: the left one's line is fanned out to both
  Net pmd_trigger{};    // not wired: as right_trigger
  Net left_strobe{};
  Net right_strobe{};
  Net pair_button{};  // connects its line with ground
};

// A pair of cameras as one of the kernel's interfaces knows them, and how their trigger is driven.
struct PairConfig {
  const char* left = "";   // empty: this board has no pair of that kind
  const char* right = "";  // empty: both pictures side by side come from `left`
  bool active_low = false;
  // How long the trigger is active; 0: as long as they shall expose, which ends `pulse_lag` later.
  hal::Duration pulse{};
  hal::Duration pulse_lag{};
  hal::Duration most_delay{};  // a frame's stamp is at most this much later than its exposure's end
};

struct PmdDeviceConfig {
  std::uint16_t usb_vendor = 0;
  std::uint16_t usb_product = 0;
  std::uint32_t modulation_khz = 20'000;
  std::uint32_t integration_us = 2'000;  // of one sample; readout comes on top
  // A frame whose edge, by the camera's clock, lies this close to one of ours is of that one.
  hal::Duration edge_tolerance = std::chrono::milliseconds(2);
};

// The devices of a board beside the processor; none on an emulated one.
struct DeviceConfig {
  Nets nets{};
  PairConfig v4l2{};
  PairConfig libcamera{};
  PmdDeviceConfig pmd{};
  const char* watchdog = "";         // device file; empty: none
  hal::Duration watchdog_timeout{};  // a loop that stands still for that long restarts the board
  // SCHED_FIFO, of what computes frames; 0: as everything else. Below 50, which the threads behind
  // interrupts have: frames are stamped by them.
  int priority = 0;
};

// The rig as it is drawn, before anything was measured: lenses in pixels of the largest pictures,
// metres.
struct NominalRig {
  double stereo_focal_px = 0;
  double baseline_m = 0;
  double pmd_focal_px = 0;
  double pmd_right_m = 0;  // of the left camera
  double pmd_below_m = 0;
};

struct Config {
  const char* name = "";
  StereoConfig stereo;
  PmdConfig pmd;
  TimingConfig timing;
  DeviceConfig devices{};
  NominalRig nominal{};
  std::size_t workspace_limit = 0;  // bytes that the memory of the frame path must stay within
};

// How long the trigger of a pair is active for that exposure.
constexpr hal::Duration pulse_length(const PairConfig& pair, hal::Duration exposure) noexcept {
  return pair.pulse > hal::Duration::zero() ? pair.pulse : exposure - pair.pulse_lag;
}

// With a shorter period stamps do not tell one edge's frames from the next one's.
constexpr hal::Duration least_period(const PairConfig& pair, const TimingConfig& timing) noexcept {
  return timing.stereo_exposure + pair.most_delay;
}

// The loop kicks the watchdog once a period: it has to outlast three.
constexpr hal::Duration least_watchdog_timeout(hal::Duration period) noexcept { return 3 * period; }

// The pair can be driven with this timing: the pulse fits into the exposure, and a stamp tells one
// edge from the next.
constexpr bool valid(const PairConfig& pair, const TimingConfig& timing) noexcept {
  const hal::Duration pulse = pulse_length(pair, timing.stereo_exposure);
  return *pair.left == '\0' ||
         (pulse > hal::Duration::zero() && pulse <= timing.stereo_exposure &&
          pair.most_delay > hal::Duration::zero() && least_period(pair, timing) <= timing.period);
}

constexpr bool valid(const DeviceConfig& devices, const TimingConfig& timing) noexcept {
  return 4 * std::chrono::microseconds(devices.pmd.integration_us) <= timing.pmd_integration &&
         2 * devices.pmd.edge_tolerance < timing.period && valid(devices.v4l2, timing) &&
         valid(devices.libcamera, timing) && devices.priority >= 0 && devices.priority < 50 &&
         (*devices.watchdog == '\0' ||
          devices.watchdog_timeout >= least_watchdog_timeout(timing.period));
}

constexpr bool valid(const Config& config) noexcept {
  const TimingConfig& timing = config.timing;
  return config.stereo.width > 0 && config.stereo.height > 0 && config.stereo.disparities > 0 &&
         config.stereo.block_width >= 1 && config.stereo.block_width <= 64 &&
         config.stereo.block_height >= 1 && config.stereo.block_height <= 64 &&
         config.pmd.width >= 0 && config.pmd.height >= 0 && *problem(timing) == '\0' &&
         timing.stereo_exposure > hal::Duration::zero() && valid(config.devices, timing);
}

}  // namespace stof::board
