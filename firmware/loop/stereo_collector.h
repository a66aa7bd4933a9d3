#pragma once

#include <optional>

#include "board/board.h"
#include "dsp/base/status.h"
#include "firmware/loop/device_lending.h"
#include "firmware/loop/loop_conditions.h"
#include "firmware/loop/pairing.h"
#include "firmware/loop/repeat_detector.h"
#include "firmware/pipeline/pipeline.h"
#include "hal/borrowed_frame.h"
#include "hal/stereo_camera.h"
#include "hal/time.h"

namespace stof::firmware {

// Takes from the pair of cameras the frame of an edge. All others are dropped and counted, and so
// is a frame of this edge that shows a picture of before, unless the pictures are recorded.
class StereoCollector {
 public:
  using Borrowed = hal::BorrowedFrame<hal::StereoFrame>;

  // Frames have the sizes of the setup's calibration. lending: a pair that is lent is not asked;
  // nullptr: it never is.
  StereoCollector(board::Board& board, const Setup& setup, LoopConditions& conditions,
                  const DeviceLending* lending) noexcept;

  // Blocks until `deadline` at most. kOk: `found` is the frame; else what the camera said last.
  Status collect(const ExposureWindow& window, hal::Time deadline,
                 std::optional<Borrowed>& found) noexcept;
  // Why the last collect() found none.
  const Absence& absence() const noexcept { return absence_; }
  // The pair is opened again because it repeats itself: its numbers may start anew.
  void expect_anew() noexcept { pairing_.expect_another(); }

 private:
  // Judges a frame; where it is dropped because an eye repeats, absence_ says so.
  Drop judge(const ExposureWindow& window, const hal::StereoFrame& frame) noexcept;
  Status next(hal::Time deadline, std::optional<Borrowed>& frame) noexcept;
  bool usable() const noexcept {
    return lending_ == nullptr || lending_->usable(board::Device::kStereo);
  }

  board::Board& board_;
  LoopConditions& conditions_;
  const DeviceLending* lending_;
  StereoPairing pairing_;
  RepeatDetector<std::uint8_t> left_;
  RepeatDetector<std::uint8_t> right_;
  Absence absence_;
};

}  // namespace stof::firmware
