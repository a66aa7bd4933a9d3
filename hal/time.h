#pragma once

#include <chrono>

namespace stof::hal {

// CLOCK_MONOTONIC of the machine that runs the loop (or an emulated one). Adapters convert.
struct Monotonic {
  using rep = std::chrono::nanoseconds::rep;
  using period = std::chrono::nanoseconds::period;
  using duration = std::chrono::nanoseconds;
  using time_point = std::chrono::time_point<Monotonic>;
  static constexpr bool is_steady = true;
};
using Duration = std::chrono::nanoseconds;
using Time = std::chrono::time_point<Monotonic, Duration>;

// [begin, end): when a sensor collected light.
struct Exposure {
  Time begin;
  Time end;
  constexpr Time middle() const noexcept { return begin + (end - begin) / 2; }
};

}  // namespace stof::hal
