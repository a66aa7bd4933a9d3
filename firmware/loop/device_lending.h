#pragma once

#include <array>
#include <atomic>
#include <chrono>
#include <cstddef>
#include <optional>

#include "board/board.h"
#include "hal/time.h"

namespace stof::firmware {

// Decides which thread may use a device: the loop's or, while it is lent, the reopener's.
//
// The loop lends a device that is lost and of which it holds no frame. Until the device is given
// back the loop does not touch it, and takes it for lost. One that is still lost then is lent again
// 50 ms after the loop has seen its return, then after twice as long each time, 250 ms at most.
// Neither end allocates; the loop's end does not block.
class DeviceLending {
 public:
  // emulated_time: no time passes while a device is opened, so that the loop waits for its return.
  explicit DeviceLending(bool emulated_time) noexcept : waits_(emulated_time) {}

  // For the loop's thread.
  bool usable(board::Device device) const noexcept { return !is_lent(device); }
  // After each round of the loop. borrowed: frames of the device have not gone home yet.
  void after_round(board::Device device, bool lost, bool borrowed, hal::Time now) noexcept;

  // For the other thread. Blocks until there is a device to open, none at the end.
  std::optional<board::Device> wait_for_lent() noexcept;
  // Opened or not: the loop finds out.
  void give_back(board::Device device) noexcept;

  // For any thread: wait_for_lent() ends.
  void end() noexcept;

 private:
  static constexpr hal::Duration kFirstBackoff = std::chrono::milliseconds(50);
  static constexpr hal::Duration kLongestBackoff = std::chrono::milliseconds(250);
  static constexpr unsigned kEnd = 1U << board::kDeviceCount;

  // As the loop knows it.
  struct Retry {
    bool tried = false;  // lent, and its return not noted yet
    hal::Time at{};      // not before
    hal::Duration backoff = kFirstBackoff;
  };

  static constexpr unsigned bit(board::Device device) noexcept {
    return 1U << static_cast<unsigned>(device);
  }
  // Each thread sees what the other did to a device before it handed it over.
  bool is_lent(board::Device device) const noexcept {
    return (lent_.load(std::memory_order_acquire) & bit(device)) != 0;
  }

  bool waits_;
  std::array<Retry, board::kDeviceCount> retries_{};
  std::atomic<unsigned> lent_{0};  // one bit a device, and kEnd
};

}  // namespace stof::firmware
