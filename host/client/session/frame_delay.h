#pragma once

#include <chrono>
#include <cstdint>
#include <optional>

#include "firmware/wire/packet.h"
#include "host/client/frame/frame.h"

namespace stof::client {

// How late frames come, by the sensor's own stamps: an exposure's middle and its arrival here
// differ by a constant (the two clocks), by the drift of the clocks, and by the way. The smallest
// difference of the session is the way of a frame that nobody held back; what comes later than that
// by more than a frame may be old is refused. No clock: times are the caller's.
//
// What ends a refusal that goes on, as after a clock that stood or was slewed: without signatures a
// second, for anybody can forge a stamp. With signatures time alone never does, else whoever slows
// the stream would only have to wait: a new stream key has to come (prove()). What it signs was
// sent after it was asked for, so the difference begins anew only with a packet that comes soon
// after.
class FrameDelay {
 public:
  static constexpr Duration kPatience = std::chrono::seconds(1);

  enum class Verdict : std::uint8_t { kTimely, kLate, kResynchronised };

  // For how long this machine has slept since its start: the clock of arrivals stood.
  void slept(Duration total) noexcept { slept_ = total; }
  Duration slept() const noexcept { return slept_; }
  // Another session, another clock.
  void restart() noexcept;

  // A packet of a frame arrived then. key: number of the stream key that signed it, 0: none.
  // soon: after prove() it has to come within this time.
  void note(const wire::FrameStamp& stamp, Time arrived, std::uint32_t key, Duration soon) noexcept;
  // Of a frame whose last packet arrived then. most: that it may be late by.
  Verdict judge(const wire::FrameStamp& stamp, Time arrived, Duration most,
                bool is_signed) noexcept;

  // For kPatience all frames were late.
  bool held_back() const noexcept { return late_for_ >= kPatience; }
  // The key of this number was asked for then.
  void prove(std::uint32_t key, Time asked) noexcept { proof_ = Proof{.key = key, .asked = asked}; }

 private:
  struct Least {
    Duration difference;
    Time at;
  };
  struct Proof {
    std::uint32_t key;
    Time asked;
  };

  Duration difference(const wire::FrameStamp& stamp, Time arrived) const noexcept;
  Duration expected(Time arrived) const noexcept;

  Duration slept_{0};
  std::optional<Least> least_;
  std::optional<Time> late_since_;  // arrival of the first late frame behind the newest timely one
  Duration late_for_{0};
  std::optional<Proof> proof_;
};

}  // namespace stof::client
