#pragma once

#include <atomic>
#include <cstdint>
#include <optional>

#include "hal/emu/devices/faults.h"
#include "hal/emu/devices/live_fault.h"

namespace stof::hal::emu {

// The faults of one camera, call after call. One that hangs is frozen until it is opened again.
class CameraFaults {
 public:
  // live: outlives it; nullptr: nobody gives it any.
  explicit CameraFaults(const FaultPlan& plan, LiveFault* live = nullptr) noexcept
      : plan_(plan), live_(live) {}

  // Of the next call; never kHang.
  Fault next() noexcept {
    Fault fault = fault_of_call(plan_, calls_++, live_);
    if (fault.kind != FaultKind::kHang) {
      hangs_since_.reset();
      return fault;
    }
    const std::uint32_t openings = openings_.load(std::memory_order_relaxed);
    hangs_since_ = hangs_since_.value_or(openings);
    fault.kind = *hangs_since_ == openings ? FaultKind::kFreeze : FaultKind::kNone;
    return fault;
  }
  // Ends what hangs. For any thread.
  void reopen() noexcept { openings_.fetch_add(1, std::memory_order_relaxed); }

 private:
  FaultPlan plan_;
  LiveFault* live_;
  std::uint32_t calls_ = 0;
  std::atomic<std::uint32_t> openings_{0};
  std::optional<std::uint32_t> hangs_since_;  // openings_ when it began to hang
};

}  // namespace stof::hal::emu
