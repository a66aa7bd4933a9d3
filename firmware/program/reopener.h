#pragma once

#include <thread>

#include "board/board.h"
#include "firmware/loop/device_lending.h"

namespace stof::firmware {

// The thread that opens devices again which the loop has lent to it. It sleeps while there are
// none. It has the priority of the thread that starts it. The destructor waits for a running
// attempt.
class Reopener {
 public:
  // Both outlive it.
  Reopener(board::Board& board, DeviceLending& lending);
  ~Reopener();
  Reopener(const Reopener&) = delete;
  Reopener& operator=(const Reopener&) = delete;

 private:
  DeviceLending& lending_;
  std::thread thread_;
};

}  // namespace stof::firmware
