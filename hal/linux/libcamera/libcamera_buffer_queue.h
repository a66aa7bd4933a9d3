#pragma once

#include <array>
#include <atomic>
#include <cstdint>
#include <optional>

#include "hal/time.h"

namespace stof::hal::linux {

// A camera's report of a filled buffer.
struct LibcameraArrival {
  Time stamp;
  std::uint32_t sequence = 0;
  bool damaged = false;
};

// Filled buffers of one camera on their way from libcamera's thread to the loop's: what FrameSlots
// is within one thread. Each slot is with the camera, waiting here or taken by the loop; nobody
// locks, nobody allocates. So that the camera never starves, `reserve` slots stay with it: then the
// oldest that waits makes room for the newest, and where none waits the newest is dropped.
class LibcameraBufferQueue {
 public:
  static constexpr int kMostSlots = 16;

  // While neither thread uses it: all slots are with the camera. 0 <= reserve < slots.
  void reset(int slots, int reserve) noexcept;

  // Libcamera's thread. The slot that has to go to the camera again at once, if any: `slot` itself
  // or an older one.
  std::optional<int> deliver(int slot, const LibcameraArrival& arrival) noexcept;

  // The loop's thread. The oldest that waits.
  std::optional<int> take() noexcept;
  // slot: taken.
  const LibcameraArrival& arrival(int slot) const noexcept {
    return arrivals_[static_cast<std::size_t>(slot)];
  }
  // A taken slot is about to go to the camera.
  void give_back(int slot) noexcept;

 private:
  // Lowest two bits: where the slot is; above them a number that orders the arrivals.
  static constexpr std::uint64_t kWithCamera = 0;
  static constexpr std::uint64_t kWaiting = 1;
  static constexpr std::uint64_t kTaken = 2;
  static constexpr std::uint64_t kWhere = 3;

  std::optional<int> move_oldest(std::uint64_t to) noexcept;

  std::array<std::atomic<std::uint64_t>, kMostSlots> states_{};
  std::array<LibcameraArrival, kMostSlots> arrivals_{};
  int slots_ = 0;
  int reserve_ = 0;
  std::uint64_t delivered_ = 0;  // of libcamera's thread
};

// `stamp` of libcamera in nanoseconds on the clock of hal::Time. Its documentation says
// CLOCK_BOOTTIME, its V4L2 pipelines pass on what the kernel stamps, which is CLOCK_MONOTONIC. The
// clocks differ by the time that the machine slept; a stamp that `monotonic` has not reached yet is
// of the other one. `boottime` and `monotonic` are the clocks now.
constexpr Time from_libcamera(Duration stamp, Duration monotonic, Duration boottime) noexcept {
  return Time(stamp <= monotonic ? stamp : stamp - (boottime - monotonic));
}

}  // namespace stof::hal::linux
