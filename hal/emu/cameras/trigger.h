#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <initializer_list>

#include "hal/clock.h"
#include "hal/emu/devices/faults.h"
#include "hal/emu/devices/live_fault.h"
#include "hal/trigger.h"

namespace stof::hal::emu {

// Whatever hangs on the trigger line.
class EdgeListener {
 public:
  virtual ~EdgeListener() = default;
  // A rising edge at `edge`, which may lie ahead of the clock. Does not block.
  virtual void on_edge(Time edge) noexcept = 0;
};

// One line to all cameras. pulse() takes `width` on the clock (and the duration of a kDelay fault).
// Clock, listeners and live faults must outlive it. Faults: faults.h.
class Trigger final : public hal::Trigger {
 public:
  static constexpr std::size_t kMaxListeners = 4;

  Trigger(hal::Clock& clock, Duration width, std::initializer_list<EdgeListener*> listeners,
          const FaultPlan& faults = {}, LiveFault* live = nullptr) noexcept;

  Result<Time> pulse() noexcept override;

 private:
  void drive(Time edge) noexcept;

  hal::Clock& clock_;
  Duration width_;
  FaultPlan faults_;
  LiveFault* live_;
  std::array<EdgeListener*, kMaxListeners> listeners_{};
  std::size_t listener_count_ = 0;
  std::uint32_t calls_ = 0;
};

}  // namespace stof::hal::emu
