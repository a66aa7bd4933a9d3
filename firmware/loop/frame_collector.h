#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>

#include "board/board.h"
#include "board/timing.h"
#include "dsp/base/status.h"
#include "firmware/loop/device_lending.h"
#include "firmware/loop/loop_conditions.h"
#include "firmware/loop/pairing.h"
#include "firmware/pipeline/pipeline.h"
#include "firmware/pipeline/shot.h"
#include "hal/borrowed_frame.h"
#include "hal/time.h"

namespace stof::firmware {

// The result of an edge.
struct Collected {
  std::optional<Shot> shot;
  bool lost = false;  // a camera has to be reopened
};

// Takes from the cameras the frames that belong to an edge. Frames of other edges are dropped and
// counted. With a PMD camera at every k-th edge, k > 1, edges between keep the last samples. These
// are at most 2 k - 2 periods old, because an integration may take k periods.
class FrameCollector {
 public:
  // Frames have the sizes of the setup's calibration. lending: cameras that are lent are not asked;
  // nullptr: none ever is.
  FrameCollector(board::Board& board, const Setup& setup, LoopConditions& conditions,
                 const DeviceLending* lending = nullptr) noexcept;

  // Blocks until `deadline` at most. search_first: searches the pair while the PMD camera still
  // integrates, and forgets it where there is no shot; nullptr: nothing is searched.
  Collected collect(hal::Time edge, hal::Time deadline, const board::TimingConfig& timing,
                    Pipeline* search_first) noexcept;
  // A frame of the PMD camera waits for its shot.
  bool holds_pmd() const noexcept { return pmd_.has_value(); }

 private:
  using BorrowedStereo = hal::BorrowedFrame<hal::StereoFrame>;
  using BorrowedPmd = hal::BorrowedFrame<hal::PmdFrame>;

  bool usable(board::Device device) const noexcept {
    return lending_ == nullptr || lending_->usable(device);
  }
  Status collect_stereo(const ExposureWindow& window, hal::Time deadline,
                        std::optional<BorrowedStereo>& found) noexcept;
  Status collect_pmd(hal::Time edge, hal::Time deadline,
                     const board::TimingConfig& timing) noexcept;
  bool pmd_usable(hal::Time edge, const board::TimingConfig& timing) const noexcept;
  Shot make_shot(hal::Time edge, BorrowedStereo&& stereo) noexcept;
  void remember_edge(hal::Time edge, const board::TimingConfig& timing) noexcept;

  board::Board& board_;
  LoopConditions& conditions_;
  const DeviceLending* lending_;
  StereoPairing stereo_pairing_;
  PmdPairing pmd_pairing_;
  // The windows of the last edges, newest first.
  std::array<ExposureWindow, 2 * board::kMostPmdEvery - 1> pmd_windows_{};
  std::size_t pmd_window_count_ = 0;
  std::optional<BorrowedPmd> pmd_;     // accepted, and not in a shot yet
  std::optional<hal::Time> pmd_edge_;  // of the last accepted PMD frame
  std::optional<hal::Time> pmd_exposed_;
  std::uint32_t freshness_ = 0;
};

}  // namespace stof::firmware
