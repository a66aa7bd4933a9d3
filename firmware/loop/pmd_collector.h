#pragma once

#include <array>
#include <cstddef>
#include <optional>

#include "board/board.h"
#include "board/timing.h"
#include "dsp/base/status.h"
#include "firmware/loop/device_lending.h"
#include "firmware/loop/light_guard.h"
#include "firmware/loop/loop_conditions.h"
#include "firmware/loop/pairing.h"
#include "firmware/loop/repeat_detector.h"
#include "firmware/pipeline/pipeline.h"
#include "hal/borrowed_frame.h"
#include "hal/pmd_camera.h"
#include "hal/time.h"

namespace stof::firmware {

// Takes from the PMD camera the samples of an edge. Those of other edges are dropped and counted,
// and so are samples of this edge that came before, unless they are recorded, or that hold no light
// of the lamp.
// Of a camera at every k-th edge, k > 1, the last samples serve the edges between. These are at
// most 2 k - 2 periods old, because an integration may take k periods.
class PmdCollector {
 public:
  using Borrowed = hal::BorrowedFrame<hal::PmdFrame>;

  // As a StereoCollector's. A board without a PMD camera never has samples.
  PmdCollector(board::Board& board, const Setup& setup, LoopConditions& conditions,
               const DeviceLending* lending) noexcept;

  // Blocks until `deadline` at most, and not where there are samples that serve this edge.
  Status collect(hal::Time edge, hal::Time deadline, const board::TimingConfig& timing) noexcept;
  // The newest samples serve this edge.
  bool serves(hal::Time edge, const board::TimingConfig& timing) const noexcept;
  // Middle of their exposure.
  const std::optional<hal::Time>& exposed() const noexcept { return exposed_; }
  // Why there are none that serve.
  const Absence& absence() const noexcept { return absence_; }
  // Samples are judged by another calibration, of the same sizes.
  void recalibrate(const Setup& setup) noexcept;
  // The camera is opened again because it repeats itself: its numbers may start anew.
  void expect_anew() noexcept { pairing_.expect_another(); }

  // No shot has had them yet.
  bool holds_new() const noexcept { return new_.has_value(); }
  std::optional<Borrowed> take_new() noexcept;
  // Samples of before serve no edge any more.
  void forget() noexcept;

 private:
  Status next(hal::Time deadline, std::optional<Borrowed>& frame) noexcept;
  // Keeps a frame that belongs to one of the last edges; absence_ says why another is dropped.
  void take(Borrowed&& frame) noexcept;
  PmdVerdict judge(const hal::PmdFrame& frame) noexcept;
  void remember_edge(hal::Time edge, const board::TimingConfig& timing) noexcept;
  bool usable() const noexcept {
    return lending_ == nullptr || lending_->usable(board::Device::kPmd);
  }

  board::Board& board_;
  LoopConditions& conditions_;
  const DeviceLending* lending_;
  PmdPairing pairing_;
  RepeatDetector<std::uint16_t> samples_;
  LightGuard light_;
  // The windows of the last edges, newest first.
  std::array<ExposureWindow, 2 * board::kMostPmdEvery - 1> windows_{};
  std::size_t window_count_ = 0;
  std::optional<Borrowed> new_;
  std::optional<hal::Time> edge_;  // of the newest samples
  std::optional<hal::Time> exposed_;
  int quiet_edges_ = 0;  // in a row at which nothing came
  Absence absence_;
};

}  // namespace stof::firmware
