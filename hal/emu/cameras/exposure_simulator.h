#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>

#include "dsp/base/status.h"
#include "hal/borrowed_frame.h"
#include "hal/clock.h"
#include "hal/emu/cameras/camera_faults.h"
#include "hal/emu/devices/faults.h"
#include "hal/frame_slots.h"
#include "hal/time.h"

namespace stof::hal::emu {

inline constexpr int kCameraSlots = 4;

// The life of an exposure in an emulated camera, from the edge to the reader, with its faults: what
// all cameras have in common. `Made` is what one exposure is known by: it has a `number` (0 before
// the first) and an end().
template <typename Made>
class ExposureSimulator final : private SlotOwner {
 public:
  // Buffers of the camera's pictures, one a slot; the last is for an exposure without a slot yet.
  static constexpr std::size_t kBuffers = kCameraSlots + 1;

  // A frame has two halves (two views, or the first and the last two samples): in a torn frame the
  // second one is the exposure before. The first gives the frame its name.
  struct Shot {
    Made first;
    Made second;
    Time ready{};
    bool corrupt = false;
    std::uint32_t frozen = 0;  // the exposure whose pixels it has; 0: its own
    bool dark = false;
  };
  ExposureSimulator(Duration readout, const FaultPlan& faults, LiveFault* live) noexcept
      : readout_(readout), faults_(faults, live) {}

  // Ends what hangs. For any thread.
  void reopen() noexcept { faults_.reopen(); }

  // An edge at which the camera would expose: expose(number) tells what it would make. An edge
  // during an exposure is ignored.
  template <typename Expose>
  void on_edge(Time edge, const Expose& expose) noexcept {
    const Fault fault = faults_.next();
    gone_ = fault.kind == FaultKind::kVanish;
    if (gone_) {
      slots_.drop_waiting();
      return;
    }
    if (last_made_.number != 0 && edge < last_made_.end()) {
      return;
    }
    const Made before = last_made_;
    last_made_ = expose(before.number + 1);
    const std::optional<Shot> shot = arriving(before, fault);
    if (!shot) {
      return;
    }
    if (!shot->corrupt) {
      last_arrived_ = shot;
    }
    const int buffer = slots_.take_free();
    shot_of(buffer) = *shot;
    slots_.push(buffer);
  }

  // The cameras' wait_frame(). fill_frame(shot, buffer) makes the frame while the shot is not ready
  // yet.
  template <typename Frame, typename Fill>
  Result<BorrowedFrame<Frame>> wait_frame(Clock& clock, Time deadline,
                                          const Fill& fill_frame) noexcept {
    if (gone_) {
      return fail(Status::kDeviceLost);
    }
    if (slots_.empty() || shot_of(slots_.oldest()).ready > std::max(deadline, clock.now())) {
      clock.wait_until(deadline);
      return fail(Status::kTimeout);
    }
    const int buffer = slots_.lend();
    const Shot& shot = shot_of(buffer);
    if (shot.corrupt) {
      clock.wait_until(shot.ready);
      slots_.release(buffer);
      return fail(Status::kCorrupt);
    }
    const Frame frame = fill_frame(shot, buffer);
    clock.wait_until(shot.ready);
    return BorrowedFrame<Frame>(frame, *this, buffer);
  }

 private:
  void give_back(int buffer) noexcept override { slots_.release(buffer); }
  Shot& shot_of(int buffer) noexcept { return shots_[static_cast<std::size_t>(buffer)]; }

  // The shot that arrives for last_made_; nothing when it never arrives.
  std::optional<Shot> arriving(const Made& before, const Fault& fault) const noexcept {
    Shot shot{.first = last_made_, .second = last_made_, .ready = last_made_.end() + readout_};
    switch (fault.kind) {
      case FaultKind::kDrop:
        return std::nullopt;
      case FaultKind::kRepeat:
        if (!last_arrived_) {
          return std::nullopt;
        }
        shot.first = last_arrived_->first;
        shot.second = last_arrived_->second;
        break;
      case FaultKind::kDelay:
        shot.ready += fault.duration;
        break;
      case FaultKind::kTear:
        shot.second = before;
        break;
      case FaultKind::kCorrupt:
        shot.corrupt = true;
        break;
      case FaultKind::kFreeze:
        if (last_arrived_) {
          shot.frozen =
              last_arrived_->frozen != 0 ? last_arrived_->frozen : last_arrived_->second.number;
        }
        break;
      case FaultKind::kDark:
        shot.dark = true;
        break;
      case FaultKind::kNone:
      case FaultKind::kVanish:
      case FaultKind::kHang:  // CameraFaults says what it is
        break;
    }
    return shot;
  }

  Duration readout_;
  CameraFaults faults_;
  FrameSlots<kCameraSlots, kBuffers - kCameraSlots> slots_;
  std::array<Shot, kBuffers> shots_{};
  Made last_made_{};
  std::optional<Shot> last_arrived_;
  bool gone_ = false;
};

}  // namespace stof::hal::emu
