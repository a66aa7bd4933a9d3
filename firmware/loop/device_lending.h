#pragma once

#include <array>
#include <atomic>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <optional>

#include "board/board.h"
#include "hal/time.h"

namespace stof::firmware {

// Decides which thread may use a device: the loop's or, while it is lent, the reopener's.
//
// The loop lends a device that is lost, or that repeats itself, and of which it holds no frame.
// Until the device is given back the loop does not touch it, and takes it for what it was. One that
// is still lost then is lent again 50 ms after the loop has seen its return, then after twice as
// long each time, 250 ms at most. One that still repeats itself, or does so again, waits 250 ms and
// at most a second: opening it takes away what else it sends. It is lent at once again after it was
// well for a second. Neither end allocates; the loop's end does not block.
class DeviceLending {
 public:
  // Why a device is to be opened again.
  enum class Need : std::uint8_t { kNone, kRepeats, kLost };

  // emulated_time: no time passes while a device is opened, so that the loop waits for its return.
  explicit DeviceLending(bool emulated_time) noexcept : waits_(emulated_time) {}

  // For the loop's thread.
  bool usable(board::Device device) const noexcept { return !is_lent(device); }
  // After each round of the loop. borrowed: frames of the device have not gone home yet. Whether it
  // was lent.
  bool after_round(board::Device device, Need need, bool borrowed, hal::Time now) noexcept;

  // For the other thread. Blocks until there is a device to open, none at the end.
  std::optional<board::Device> wait_for_lent() noexcept;
  // Opened or not: the loop finds out.
  void give_back(board::Device device) noexcept;

  // For any thread: wait_for_lent() ends.
  void end() noexcept;

 private:
  static constexpr unsigned kEnd = 1U << board::kDeviceCount;

  // When a device may be lent again.
  class Pace {
   public:
    constexpr Pace(hal::Duration first, hal::Duration longest) noexcept
        : first_(first), longest_(longest), backoff_(first) {}
    bool due(hal::Time now) const noexcept { return now >= at_; }
    void lend() noexcept { tried_ = true; }
    void note_return(hal::Time now) noexcept;  // nothing where it was not lent
    void start_over() noexcept { backoff_ = first_; }
    bool long_past(hal::Time now) const noexcept { return now - at_ >= longest_; }

   private:
    hal::Duration first_;
    hal::Duration longest_;
    hal::Duration backoff_;
    hal::Time at_{};      // not before
    bool tried_ = false;  // lent, and its return not noted yet
  };
  struct Retry {
    Pace lost{std::chrono::milliseconds(50), std::chrono::milliseconds(250)};
    Pace repeats{std::chrono::milliseconds(250), std::chrono::seconds(1)};
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
