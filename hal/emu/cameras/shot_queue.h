#pragma once

#include <array>
#include <cstddef>
#include <optional>

#include "dsp/base/check.h"
#include "dsp/base/index.h"

namespace stof::hal::emu {

inline constexpr int kCameraSlots = 4;

// Which frame slots of a camera are free, waiting to be read (oldest first) or out on a lease.
// A Shot is what the camera knows about the exposure in the slot.
template <typename Shot>
class ShotQueue {
 public:
  // Takes a free slot, else that of the oldest waiting shot, which is lost. With all slots out the
  // new shot is lost. Returns whether nothing was lost.
  bool push(const Shot& shot) noexcept {
    bool kept = true;
    int slot = find_free();
    if (slot < 0) {
      kept = false;
      if (waiting_ == 0) {
        return kept;
      }
      slot = take();
    }
    shots_[dsp::index(slot)] = shot;
    busy_[dsp::index(slot)] = true;
    order_[dsp::index(waiting_++)] = slot;
    return kept;
  }

  // The oldest waiting shot, or nullptr.
  const Shot* oldest() const noexcept {
    return waiting_ == 0 ? nullptr : &shots_[dsp::index(order_[0])];
  }
  // Takes the oldest waiting shot out of the queue; its slot stays busy until release().
  int take() noexcept {
    STOF_CHECK(waiting_ > 0);
    const int slot = order_[0];
    --waiting_;
    for (int i = 0; i < waiting_; ++i) {
      order_[dsp::index(i)] = order_[dsp::index(i + 1)];
    }
    return slot;
  }
  void release(int slot) noexcept {
    STOF_CHECK(slot >= 0 && slot < kCameraSlots && busy_[dsp::index(slot)]);
    busy_[dsp::index(slot)] = false;
  }
  void drop_waiting() noexcept {
    while (waiting_ > 0) {
      release(take());
    }
  }

 private:
  int find_free() const noexcept {
    for (int slot = 0; slot < kCameraSlots; ++slot) {
      if (!busy_[dsp::index(slot)]) {
        return slot;
      }
    }
    return -1;
  }

  std::array<Shot, kCameraSlots> shots_{};
  std::array<bool, kCameraSlots> busy_{};
  std::array<int, kCameraSlots> order_{};
  int waiting_ = 0;
};

}  // namespace stof::hal::emu
