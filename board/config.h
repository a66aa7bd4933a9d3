#pragma once

#include <chrono>
#include <cstddef>

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

struct TimingConfig {
  hal::Duration period{};  // of the trigger
  hal::Duration stereo_exposure{};
  hal::Duration pmd_integration{};  // all four samples
  hal::Duration edge_tolerance{};   // an exposure begins this near to its edge
  int pmd_every = 1;                // the PMD camera exposes at every k-th edge

  friend constexpr bool operator==(const TimingConfig&, const TimingConfig&) = default;
};

struct Config {
  const char* name = "";
  StereoConfig stereo;
  PmdConfig pmd;
  TimingConfig timing;
  std::size_t workspace_limit = 0;  // bytes that the memory of the frame path must stay within
};

constexpr bool valid(const Config& config) noexcept {
  const TimingConfig& timing = config.timing;
  return config.stereo.width > 0 && config.stereo.height > 0 && config.stereo.disparities > 0 &&
         config.stereo.block_width >= 1 && config.stereo.block_width <= 64 &&
         config.stereo.block_height >= 1 && config.stereo.block_height <= 64 &&
         config.pmd.width >= 0 && config.pmd.height >= 0 && timing.pmd_every >= 1 &&
         timing.stereo_exposure > hal::Duration::zero() &&
         timing.period > timing.stereo_exposure + timing.edge_tolerance &&
         timing.period * timing.pmd_every > timing.pmd_integration + timing.edge_tolerance &&
         timing.edge_tolerance > hal::Duration::zero();
}

}  // namespace stof::board
