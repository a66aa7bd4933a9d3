#pragma once

#include <chrono>

#include "host/client/frame/frame.h"

namespace stof::client {

// For how long this machine has slept since its start: CLOCK_MONOTONIC, which frames are judged by,
// stood. Where it cannot be told, `before`.
Duration time_asleep(Duration before) noexcept;

// When the datagrams of a socket arrived, on the clock that frames are judged by. The system stamps
// them with the wall clock, which somebody may set in between. A datagram lies in a queue: it
// arrived after the one before it and before it was read. Of the readings of a stamp, with the wall
// clock as it stands now and as it stood when the queue was last empty, the earliest that fits
// counts; where none fits, the earliest time that is possible. So nothing old is taken for new, and
// what is new may look old only until the queue has been emptied after the clock was set.
class ArrivalClock {
 public:
  struct Now {
    Time monotonic;
    std::chrono::nanoseconds wall;
  };
  static Now now() noexcept;

  explicit ArrivalClock(const Now& now) noexcept : read_(now), earliest_(now.monotonic) {}

  // A batch of datagrams was read at `now`.
  void read(const Now& now) noexcept { read_ = now; }
  // Of the batch's datagrams, in their order. Never earlier than the one before.
  Time arrival(std::chrono::nanoseconds stamp) noexcept;
  // The queue was empty at `at`, not later than the newest read().
  void emptied(Time at) noexcept;

 private:
  static constexpr Duration kTolerance = std::chrono::milliseconds(10);  // of two clocks read apart

  std::chrono::nanoseconds offset() const noexcept;

  Now read_;
  Time earliest_;                                  // that the next datagram can have arrived at
  std::chrono::nanoseconds old_offset_{offset()};  // wall clock less ours, of the empty queue
};

}  // namespace stof::client
