#pragma once

#include <array>
#include <chrono>
#include <cstddef>
#include <optional>

#include "host/client/frame/frame.h"

namespace stof::client {

// How far apart frames come, which bounds what a sensor, or whoever speaks in its name, says of its
// period: a longer one makes nobody wait longer for the next frame until frames have come so far
// apart. Starts of the sensor make no difference. No clock: times are the caller's.
class FramePace {
 public:
  // No sensor takes more (setting period_ms).
  static constexpr Duration kLongest = std::chrono::seconds(60);
  // Before its second frame no more is believed.
  static constexpr Duration kUnproven = std::chrono::seconds(1);

  // A frame that is newer than all before.
  void note(Time arrived) noexcept;
  // The period to go by, where the sensor tells this one; 0: not known.
  Duration believed(Duration told) const noexcept;

 private:
  // More than frames that a stalled network or reader gets at once.
  static constexpr std::size_t kGaps = 32;

  std::optional<Time> newest_;
  std::array<Duration, kGaps> gaps_{};  // the newest ones; 0: none yet
  std::size_t noted_ = 0;               // ever
};

}  // namespace stof::client
