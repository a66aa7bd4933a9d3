#include "firmware/loop/stereo_collector.h"

#include <utility>

namespace stof::firmware {

StereoCollector::StereoCollector(board::Board& board, const Setup& setup,
                                 LoopConditions& conditions, const DeviceLending* lending) noexcept
    : board_(board),
      conditions_(conditions),
      lending_(lending),
      pairing_(setup.calibration.stereo.left.width, setup.calibration.stereo.left.height) {}

Status StereoCollector::next(hal::Time deadline, std::optional<Borrowed>& frame) noexcept {
  const bool usable = lending_ == nullptr || lending_->usable(board::Device::kStereo);
  Result<Borrowed> taken = usable ? board_.stereo.wait_frame(deadline) : fail(Status::kDeviceLost);
  const Status status = taken ? Status::kOk : taken.error();
  conditions_.note_device_status(Component::kStereo, status);
  if (taken) {
    frame.emplace(std::move(*taken));
  } else if (status == Status::kDeviceLost) {
    pairing_.forget();
  }
  return status;
}

Status StereoCollector::collect(const ExposureWindow& window, hal::Time deadline,
                                std::optional<Borrowed>& found) noexcept {
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
    const Drop drop = pairing_.judge(window, **frame);
    if (drop == Drop::kNone) {
      found.emplace(std::move(*frame));
      return Status::kOk;
    }
    ++of(conditions_.counters().stereo_dropped, drop);
  }
  return last;
}

}  // namespace stof::firmware
