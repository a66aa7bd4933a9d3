#pragma once

#include <atomic>
#include <cstdint>

#include "hal/emu/devices/faults.h"

namespace stof::hal::emu {

// A fault that a running device is given, in place of those of its plan: until its calls are over,
// it is ended or another one is given. Any thread gives, the device's own takes.
class LiveFault {
 public:
  struct State {
    FaultKind kind = FaultKind::kNone;
    std::uint32_t calls = 0;  // that it will still strike; Fault::kForever: until it is ended
  };

  // kNone, or no calls: ends what there is.
  void give(State state) noexcept {
    state_.store(state.kind == FaultKind::kNone || state.calls == 0 ? 0 : packed(state),
                 std::memory_order_relaxed);
  }
  State left() const noexcept { return unpacked(state_.load(std::memory_order_relaxed)); }

  // Of the next call, which it takes; kNone: none strikes.
  FaultKind take() noexcept {
    std::uint64_t before = state_.load(std::memory_order_relaxed);
    while (before != 0) {
      State state = unpacked(before);
      if (state.calls == Fault::kForever) {
        return state.kind;
      }
      --state.calls;
      if (state_.compare_exchange_weak(before, state.calls == 0 ? 0 : packed(state),
                                       std::memory_order_relaxed)) {
        return state.kind;
      }
    }
    return FaultKind::kNone;
  }

 private:
  static_assert(std::atomic<std::uint64_t>::is_always_lock_free);
  static constexpr std::uint64_t packed(State state) noexcept {
    return std::uint64_t{static_cast<std::uint8_t>(state.kind)} << 32 | state.calls;
  }
  static constexpr State unpacked(std::uint64_t bits) noexcept {
    return {.kind = static_cast<FaultKind>(bits >> 32), .calls = static_cast<std::uint32_t>(bits)};
  }

  std::atomic<std::uint64_t> state_{0};  // 0: none
};

// What strikes at a call of a device. live: may be nullptr.
inline Fault fault_of_call(const FaultPlan& plan, std::uint32_t call, LiveFault* live) noexcept {
  if (const FaultKind given = live == nullptr ? FaultKind::kNone : live->take();
      given != FaultKind::kNone) {
    return {.kind = given, .call = call, .duration = kUsualFaultDuration};
  }
  return plan.at(call);
}

}  // namespace stof::hal::emu
