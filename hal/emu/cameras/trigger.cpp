#include "hal/emu/cameras/trigger.h"

#include "dsp/base/check.h"

namespace stof::hal::emu {

Trigger::Trigger(hal::Clock& clock, Duration width, std::initializer_list<EdgeListener*> listeners,
                 const FaultPlan& faults, LiveFault* live) noexcept
    : clock_(clock), width_(width), faults_(faults), live_(live) {
  STOF_CHECK(width > Duration::zero() && listeners.size() <= kMaxListeners);
  for (EdgeListener* const listener : listeners) {
    STOF_CHECK(listener != nullptr);
    listeners_[listener_count_++] = listener;
  }
}

Result<Time> Trigger::pulse() noexcept {
  const Fault fault = fault_of_call(faults_, calls_++, live_);
  if (fault.kind == FaultKind::kVanish) {
    return fail(Status::kDeviceLost);
  }
  if (fault.kind == FaultKind::kCorrupt) {
    return fail(Status::kDeviceError);
  }
  if (fault.kind == FaultKind::kDelay) {
    clock_.wait_until(clock_.now() + fault.duration);
  }
  const Time edge = clock_.now();
  if (fault.kind != FaultKind::kDrop) {
    drive(edge);
  }
  if (fault.kind == FaultKind::kRepeat) {
    drive(edge + fault.duration);
  }
  clock_.wait_until(edge + width_);
  if (fault.kind == FaultKind::kTear) {
    return fail(Status::kDeviceError);
  }
  return edge;
}

void Trigger::drive(Time edge) noexcept {
  for (std::size_t i = 0; i < listener_count_; ++i) {
    listeners_[i]->on_edge(edge);
  }
}

}  // namespace stof::hal::emu
