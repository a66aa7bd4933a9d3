#pragma once

#include <algorithm>
#include <cstdint>
#include <optional>

#include "dsp/base/status.h"
#include "hal/clock.h"
#include "hal/emu/cameras/shot_queue.h"
#include "hal/emu/devices/faults.h"
#include "hal/time.h"

namespace stof::hal::emu {

// The life of an exposure in an emulated camera, from the edge to the reader, with its faults: what
// all cameras have in common. `Made` is what one exposure is known by: it has a `number` (0 before
// the first) and an end().
template <typename Made>
class Exposer {
 public:
  // A frame has two halves (two views, or the first and the last two samples): in a torn frame the
  // second one is the exposure before. The first gives the frame its name.
  struct Shot {
    Made first;
    Made second;
    Time ready{};
    bool corrupt = false;
  };
  struct Taken {
    Shot shot;
    int slot = 0;
  };

  Exposer(Duration readout, const FaultPlan& faults) noexcept
      : readout_(readout), faults_(faults) {}

  // An edge at which the camera would expose: expose(number) tells what it would make. An edge
  // during an exposure is ignored.
  template <typename Expose>
  void on_edge(Time edge, const Expose& expose) noexcept {
    const Fault fault = faults_.at(calls_++);
    gone_ = fault.kind == FaultKind::kVanish;
    if (gone_) {
      queue_.drop_waiting();
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
    queue_.push(*shot);
  }

  // The oldest shot that is ready by the deadline; its slot is the caller's until release().
  // kTimeout, kCorrupt, kDeviceLost as the cameras' wait_frame(). Does not wait for the shot
  // itself, so that pixels are made meanwhile: the caller waits until shot.ready.
  Result<Taken> take(Clock& clock, Time deadline) noexcept {
    if (gone_) {
      return fail(Status::kDeviceLost);
    }
    const Shot* const oldest = queue_.oldest();
    if (oldest == nullptr || oldest->ready > std::max(deadline, clock.now())) {
      clock.wait_until(deadline);
      return fail(Status::kTimeout);
    }
    const Shot shot = *oldest;
    const int slot = queue_.take();
    if (shot.corrupt) {
      clock.wait_until(shot.ready);
      queue_.release(slot);
      return fail(Status::kCorrupt);
    }
    return Taken{shot, slot};
  }

  void release(int slot) noexcept { queue_.release(slot); }

 private:
  // What becomes of last_made_ on its way; nothing when it never arrives.
  std::optional<Shot> arriving(const Made& before, const Fault& fault) const noexcept {
    Shot shot{last_made_, last_made_, last_made_.end() + readout_, false};
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
      case FaultKind::kNone:
      case FaultKind::kVanish:
        break;
    }
    return shot;
  }

  Duration readout_;
  FaultPlan faults_;
  ShotQueue<Shot> queue_;
  Made last_made_{};
  std::optional<Shot> last_arrived_;
  std::uint32_t calls_ = 0;
  bool gone_ = false;
};

}  // namespace stof::hal::emu
