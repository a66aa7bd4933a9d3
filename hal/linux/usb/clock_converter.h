#pragma once

#include <cstdint>
#include <optional>

#include "hal/time.h"

namespace stof::hal::linux {

// Another clock's stamps, nanoseconds that may wrap, on hal::Time. For one thread; nothing blocks.
class ClockConverter {
 public:
  // Two clocks are taken to differ by no more than this: 100 ppm, a poor crystal's.
  static constexpr std::int64_t kDriftPerMillion = 100;
  // correct_by_event() moves the clock by no more than this each time: at 10 edges a second it
  // keeps up with 200 ppm, and one wrong edge costs no more.
  static constexpr Duration kMostStep = std::chrono::microseconds(20);
  // Both ends' time of an edge, together.
  static constexpr Duration kEdgeUncertainty = std::chrono::microseconds(5);
  // Stamps further from the last one known are not converted.
  static constexpr Duration kMostSpan = std::chrono::hours(24);

  // It read `theirs` at some time between `before` and `after`. The answer with the shortest
  // way counts, until drift has made it worse than a later one; at once counts one that
  // the present reckoning cannot explain. Ignored: `after` before `before`, more than a second.
  void sync(Time before, std::uint64_t theirs, Time after) noexcept;
  // Nothing: never synchronised, or too far away.
  std::optional<Time> convert(std::uint64_t theirs) const noexcept;
  // An event whose time is known at both. False: it did not count, convert() knows no such time.
  bool correct_by_event(Time ours, std::uint64_t theirs) noexcept;
  // convert(theirs) is right to within this; nothing where it says nothing.
  std::optional<Duration> uncertainty(std::uint64_t theirs) const noexcept;
  // Forgets everything: the device began anew.
  void reset() noexcept { *this = {}; }

 private:
  // From the last stamp known; nothing: too far.
  std::optional<Duration> since(std::uint64_t theirs) const noexcept;

  bool known_ = false;
  std::uint64_t theirs_ = 0;  // ...
  Time ours_{};               // ... were at the same moment,
  Duration uncertainty_{};    // to within this
};

}  // namespace stof::hal::linux
