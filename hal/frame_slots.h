#pragma once

#include <array>
#include <cstddef>

#include "dsp/base/check.h"

namespace stof::hal {

// The owners of a camera's buffers: nobody, the device that fills one, the queue of whole frames
// (oldest first), or a borrower. If queue and borrowers have kSlots, the queue's oldest frame is
// lost; if borrowers alone have them, the new one is. kFilling buffers beside kSlots are always
// free to be filled. For one thread.
template <std::size_t kSlots, std::size_t kFilling>
class FrameSlots {
 public:
  static constexpr std::size_t kBuffers = kSlots + kFilling;

  // A free buffer, from now on the device's.
  int take_free() noexcept {
    for (std::size_t i = 0; i < kBuffers; ++i) {
      if (state_[i] == State::kFree) {
        state_[i] = State::kGiven;
        return static_cast<int>(i);
      }
    }
    STOF_CHECK(false);
    return 0;
  }
  // The device's buffer holds nothing.
  void put_back(int buffer) noexcept { change(buffer, State::kGiven, State::kFree); }
  // The device's buffer holds a frame. False: a frame was lost for it, or it itself.
  bool push(int buffer) noexcept {
    if (waiting_ + lent_ < kSlots) {
      append(buffer);
      return true;
    }
    if (waiting_ == 0) {
      put_back(buffer);
      return false;
    }
    change(first(), State::kWaiting, State::kFree);
    append(buffer);
    return false;
  }
  bool empty() const noexcept { return waiting_ == 0; }
  // Not empty.
  int oldest() const noexcept {
    STOF_CHECK(waiting_ > 0);
    return order_[0];
  }
  // That one, from now on lent.
  int lend() noexcept {
    const int buffer = first();
    change(buffer, State::kWaiting, State::kLent);
    ++lent_;
    return buffer;
  }
  void release(int buffer) noexcept {
    change(buffer, State::kLent, State::kFree);
    --lent_;
  }
  void drop_waiting() noexcept {
    while (waiting_ > 0) {
      change(first(), State::kWaiting, State::kFree);
    }
  }

 private:
  enum class State : unsigned char { kFree, kGiven, kWaiting, kLent };

  void change(int buffer, State from, State to) noexcept {
    STOF_CHECK(buffer >= 0 && static_cast<std::size_t>(buffer) < kBuffers &&
               state_[static_cast<std::size_t>(buffer)] == from);
    state_[static_cast<std::size_t>(buffer)] = to;
  }
  void append(int buffer) noexcept {
    change(buffer, State::kGiven, State::kWaiting);
    order_[waiting_++] = buffer;
  }
  // Takes the oldest out of the queue.
  int first() noexcept {
    const int buffer = oldest();
    --waiting_;
    for (std::size_t i = 0; i < waiting_; ++i) {
      order_[i] = order_[i + 1];
    }
    return buffer;
  }

  std::array<State, kBuffers> state_{};
  std::array<int, kSlots> order_{};
  std::size_t waiting_ = 0;
  std::size_t lent_ = 0;
};

}  // namespace stof::hal
