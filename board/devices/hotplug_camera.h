#pragma once

#include <algorithm>
#include <expected>
#include <functional>
#include <memory>
#include <string>
#include <utility>

#include "dsp/base/status.h"
#include "hal/borrowed_frame.h"
#include "hal/linux/open_error.h"
#include "hal/time.h"

namespace stof::board {

// A camera that need not be there when the board starts: until it is, it is lost. One that is there
// and sends nothing for seconds is lost as well: its driver may have given up without a word.
// `Camera` is the interface, `Frame` what it gives. For one thread at a time: whoever reopens it
// has it alone, and no frame of it is borrowed.
template <typename Camera, typename Frame>
class HotplugCamera final : public Camera {
 public:
  struct Opened {
    std::unique_ptr<Camera> camera;
    std::function<Status()> reopen;  // of this camera, in place
  };
  using Open = std::function<std::expected<Opened, hal::linux::OpenError>()>;

  explicit HotplugCamera(Open open) : open_(std::move(open)) { static_cast<void>(reopen()); }

  Result<hal::BorrowedFrame<Frame>> wait_frame(hal::Time deadline) noexcept override {
    if (lost_) {
      return fail(Status::kDeviceLost);
    }
    Result<hal::BorrowedFrame<Frame>> frame = opened_.camera->wait_frame(deadline);
    if (!frame && frame.error() != Status::kDeviceLost && silent(deadline)) {
      frame = fail(Status::kDeviceLost);
    }
    lost_ = !frame && frame.error() == Status::kDeviceLost;
    if (frame) {
      timeouts_ = 0;
      most_silence_ = kFirstSilence;
    }
    return frame;
  }

  // Also where it is not lost: one that repeats itself is shut and opened. May allocate.
  Status reopen() noexcept {
    if (opened_.camera == nullptr) {
      auto opened = open_();
      if (!opened) {
        why_ = std::move(opened.error().message);
        return Status::kDeviceLost;
      }
      opened_ = std::move(*opened);
      lost_ = false;
      return Status::kOk;
    }
    const Status status = opened_.reopen();
    lost_ = status != Status::kOk;
    return lost_ ? Status::kDeviceLost : Status::kOk;
  }

  // Why it could not be opened when the board started; empty: it was.
  const std::string& why() const noexcept { return why_; }

 private:
  static constexpr int kLeastTimeouts = 8;
  static constexpr hal::Duration kFirstSilence = std::chrono::seconds(3);
  static constexpr hal::Duration kLongestSilence = std::chrono::minutes(1);

  // One more wait without a frame: whether those are too many. Each time more are needed.
  bool silent(hal::Time deadline) noexcept {
    if (timeouts_++ == 0) {
      silent_since_ = deadline;
    }
    if (timeouts_ < kLeastTimeouts || deadline - silent_since_ < most_silence_) {
      return false;
    }
    timeouts_ = 0;
    most_silence_ = std::min(2 * most_silence_, kLongestSilence);
    return true;
  }

  Open open_;
  Opened opened_{};
  std::string why_;
  bool lost_ = true;
  int timeouts_ = 0;  // in a row
  hal::Time silent_since_{};
  hal::Duration most_silence_ = kFirstSilence;
};

}  // namespace stof::board
