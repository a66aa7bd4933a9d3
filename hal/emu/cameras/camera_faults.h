#pragma once

#include <atomic>
#include <cstdint>
#include <optional>

#include "hal/emu/devices/faults.h"

namespace stof::hal::emu {

// The faults of one camera, call after call. One that hangs is frozen until it is opened again.
class CameraFaults {
 public:
  explicit CameraFaults(const FaultPlan& plan) noexcept : plan_(plan) {}

  // Of the next call; never kHang.
  Fault next() noexcept {
    Fault fault = plan_.at(calls_++);
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
  std::uint32_t calls_ = 0;
  std::atomic<std::uint32_t> openings_{0};
  std::optional<std::uint32_t> hangs_since_;  // openings_ when it began to hang
};

}  // namespace stof::hal::emu
