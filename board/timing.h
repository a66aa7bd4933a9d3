#pragma once

#include <chrono>

#include "hal/time.h"

namespace stof::board {

// How a board drives its cameras.
struct TimingConfig {
  hal::Duration period{};  // of the trigger
  hal::Duration stereo_exposure{};
  hal::Duration pmd_integration{};  // all four samples
  hal::Duration edge_tolerance{};   // an exposure begins this near to its edge
  int pmd_every = 1;                // the PMD camera exposes at every k-th edge

  friend constexpr bool operator==(const TimingConfig&, const TimingConfig&) = default;
};

// The PMD camera may expose at every k-th edge, k at most this.
inline constexpr int kMostPmdEvery = 8;

// Empty, or why edges of this timing cannot be told apart or cameras cannot follow.
constexpr const char* problem(const TimingConfig& timing) noexcept {
  if (timing.pmd_every < 1 || timing.pmd_every > kMostPmdEvery) {
    return "the PMD camera must expose at every edge or at every k-th, k at most 8";
  }
  if (timing.edge_tolerance <= hal::Duration::zero() ||
      timing.period <= 16 * timing.edge_tolerance) {
    return "the period must be longer than 16 edge tolerances";
  }
  if (timing.period > std::chrono::minutes(1)) {
    return "the period must be at most a minute";
  }
  // Edges come 7/8 of a period apart at the nearest.
  const hal::Duration spacing = timing.period - timing.period / 8;
  if (spacing <= timing.stereo_exposure + timing.edge_tolerance) {
    return "7/8 of the period must be longer than the exposure of the stereo cameras";
  }
  if (timing.pmd_every * spacing <= timing.pmd_integration + timing.edge_tolerance) {
    return "7/8 of the period must be longer than the integration of the PMD camera";
  }
  return "";
}

}  // namespace stof::board
