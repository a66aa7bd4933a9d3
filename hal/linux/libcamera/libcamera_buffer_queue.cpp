#include "hal/linux/libcamera/libcamera_buffer_queue.h"

#include <cstddef>
#include <utility>

#include "dsp/base/check.h"

namespace stof::hal::linux {

void LibcameraBufferQueue::reset(int slots, int reserve) noexcept {
  STOF_CHECK(slots <= kMostSlots && reserve >= 0 && reserve < slots);
  slots_ = slots;
  reserve_ = reserve;
  for (std::atomic<std::uint64_t>& state : states_) {
    state.store(kWithCamera, std::memory_order_relaxed);
  }
}

std::optional<int> LibcameraBufferQueue::deliver(int slot,
                                                 const LibcameraArrival& arrival) noexcept {
  STOF_CHECK(slot >= 0 && slot < slots_);
  int with_camera = -1;  // without this one
  for (int i = 0; i < slots_; ++i) {
    const std::uint64_t state =
        states_[static_cast<std::size_t>(i)].load(std::memory_order_acquire);
    with_camera += (state & kWhere) == kWithCamera ? 1 : 0;
  }
  std::optional<int> back;
  if (with_camera < reserve_) {
    back = move_oldest(kWithCamera);
    if (!back) {
      return slot;
    }
  }
  const std::size_t i = static_cast<std::size_t>(slot);
  arrivals_[i] = arrival;
  states_[i].store((++delivered_ << 2) | kWaiting, std::memory_order_release);
  return back;
}

std::optional<int> LibcameraBufferQueue::take() noexcept { return move_oldest(kTaken); }

void LibcameraBufferQueue::give_back(int slot) noexcept {
  states_[static_cast<std::size_t>(slot)].store(kWithCamera, std::memory_order_release);
}

// While one looks, the other thread may deliver an older one behind and a newer one ahead. Who has
// seen the newer one sees the older one, too, when looking again.
std::optional<int> LibcameraBufferQueue::move_oldest(std::uint64_t to) noexcept {
  std::uint64_t seen = 0;
  for (;;) {
    std::optional<int> oldest;
    std::uint64_t state = 0;
    for (int i = 0; i < slots_; ++i) {
      const std::uint64_t found =
          states_[static_cast<std::size_t>(i)].load(std::memory_order_acquire);
      if ((found & kWhere) == kWaiting && (!oldest || found < state)) {
        oldest = i;
        state = found;
      }
    }
    if (!oldest) {
      return oldest;
    }
    // Fails where the other thread was faster: then there is another oldest one.
    if (state == std::exchange(seen, state) &&
        states_[static_cast<std::size_t>(*oldest)].compare_exchange_strong(
            state, (state & ~kWhere) | to, std::memory_order_acq_rel)) {
      return oldest;
    }
  }
}

}  // namespace stof::hal::linux
