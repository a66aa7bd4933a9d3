#pragma once

#include <cstdint>
#include <optional>

#include "board/board.h"
#include "board/timing.h"
#include "dsp/base/status.h"
#include "firmware/loop/device_lending.h"
#include "firmware/loop/loop_conditions.h"
#include "firmware/loop/pmd_collector.h"
#include "firmware/loop/stereo_collector.h"
#include "firmware/pipeline/pipeline.h"
#include "firmware/pipeline/shot.h"
#include "hal/time.h"

namespace stof::firmware {

// The result of an edge.
struct Collected {
  std::optional<Shot> shot;
  bool lost = false;  // a camera has to be reopened
};

// Makes the shot of an edge of what belongs to it: of both sensors, or, unless both are required,
// of the one that there is. A shot always has an exposure that none had before, and is exposed
// later than the shot before it. So with a PMD camera at every k-th edge alone, only every k-th
// edge has a shot.
class FrameCollector {
 public:
  // As a StereoCollector's.
  FrameCollector(board::Board& board, const Setup& setup, LoopConditions& conditions,
                 const DeviceLending* lending = nullptr) noexcept;

  // Without one of the sensors of this rig there is no shot.
  void require_both(bool both) noexcept { both_required_ = both; }

  // Blocks until `deadline` at most. search_first: searches the pair while the PMD camera still
  // integrates, and forgets it where there is no shot; nullptr: nothing is searched.
  Collected collect(hal::Time edge, hal::Time deadline, const board::TimingConfig& timing,
                    Pipeline* search_first) noexcept;
  // Frames are judged by another calibration, of the same sizes.
  void recalibrate(const Setup& setup) noexcept { pmd_.recalibrate(setup); }
  // A camera is opened again because it repeats itself.
  void expect_anew(board::Device camera) noexcept;
  // Samples of the PMD camera wait for their shot.
  bool holds_pmd() const noexcept { return pmd_.holds_new(); }
  // Samples that no pipeline has seen, or another one, serve no edge any more.
  void forget_pmd() noexcept { pmd_.forget(); }

 private:
  bool gives_shot(bool stereo, bool pmd) const noexcept;
  Shot make_shot(hal::Time edge, std::optional<StereoCollector::Borrowed>&& stereo,
                 bool with_pmd) noexcept;

  board::Board& board_;
  LoopConditions& conditions_;
  StereoCollector stereo_;
  PmdCollector pmd_;
  bool both_required_;
  hal::Time last_exposed_{};
  std::uint32_t freshness_ = 0;
};

}  // namespace stof::firmware
