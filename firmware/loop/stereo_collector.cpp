#include "firmware/loop/stereo_collector.h"

#include <utility>

namespace stof::firmware {
namespace {

// Grey values between these have noise: not black, not clipped.
constexpr int kDarkGrey = 16;
constexpr int kBrightGrey = 240;

}  // namespace

StereoCollector::StereoCollector(board::Board& board, const Setup& setup,
                                 LoopConditions& conditions, const DeviceLending* lending) noexcept
    : board_(board),
      conditions_(conditions),
      lending_(lending),
      pairing_(setup.calibration.stereo.left.width, setup.calibration.stereo.left.height),
      left_(kDarkGrey, kBrightGrey),
      right_(kDarkGrey, kBrightGrey) {}

Status StereoCollector::next(hal::Time deadline, std::optional<Borrowed>& frame) noexcept {
  Result<Borrowed> taken =
      usable() ? board_.stereo.wait_frame(deadline) : fail(Status::kDeviceLost);
  const Status status = taken ? Status::kOk : taken.error();
  conditions_.note_device_status(Component::kStereo, status);
  if (taken) {
    frame.emplace(std::move(*taken));
  } else if (status == Status::kDeviceLost) {
    pairing_.forget();
  }
  return status;
}

Drop StereoCollector::judge(const ExposureWindow& window, const hal::StereoFrame& frame) noexcept {
  Eyes repeating = pairing_.repeating(frame);
  Drop drop = pairing_.judge(window, frame);
  if (drop == Drop::kNone && !board_.recorded) {
    const bool left = left_.repeats({&frame.left, 1});
    const bool right = right_.repeats({&frame.right, 1});
    repeating = eyes(left, right);
    drop = repeating == kNoEye ? Drop::kNone : Drop::kStale;
  }
  if (drop != Drop::kNone && repeating != kNoEye) {
    absence_ = {.why = Absence::Why::kFrozen, .value = repeating};
  }
  return drop;
}

Status StereoCollector::collect(const ExposureWindow& window, hal::Time deadline,
                                std::optional<Borrowed>& found) noexcept {
  if (!usable() && !conditions_.lost(Component::kStereo)) {
    return Status::kTimeout;  // opened again because it repeats itself, which absence_ says
  }
  absence_ = {.why = Absence::Why::kSilent};
  Status last = Status::kTimeout;
  for (int i = 0; i < kMaxFramesPerEdge; ++i) {
    std::optional<Borrowed> frame;
    const Status status = next(deadline, frame);
    if (!frame) {
      last = status;
      if (status == Status::kCorrupt) {
        continue;  // perhaps one left over: the right one may still come
      }
      return status;
    }
    const Drop drop = judge(window, **frame);
    if (drop == Drop::kNone) {
      found.emplace(std::move(*frame));
      return Status::kOk;
    }
    ++of(conditions_.counters().stereo_dropped, drop);
  }
  return last;
}

}  // namespace stof::firmware
