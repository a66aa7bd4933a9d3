#pragma once

#include <algorithm>
#include <chrono>

#include "board/board.h"

namespace stof::firmware {

// Asks the board to reopen what is lost, soon at first, then four times a second.
class Reopener {
 public:
  explicit Reopener(board::Board& board) : board_(board) {}

  void after(Status step) noexcept {
    if (step != Status::kDeviceLost) {
      wait_ = kShortest;
      return;
    }
    const hal::Time now = board_.clock.now();
    if (now < next_) {
      return;
    }
    // Not back yet, or gone again at once: the loop goes on and tells.
    static_cast<void>(board::reopen(board_));
    next_ = now + wait_;
    wait_ = std::min(2 * wait_, kLongest);
  }

 private:
  static constexpr hal::Duration kShortest = std::chrono::milliseconds(50);
  static constexpr hal::Duration kLongest = std::chrono::milliseconds(250);

  board::Board& board_;
  hal::Time next_{};
  hal::Duration wait_ = kShortest;
};

}  // namespace stof::firmware
