#pragma once

#include <array>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <optional>

#include "host/client/frame/frame.h"

namespace stof::client {

// From a sensor's clock to this machine's (CLOCK_MONOTONIC): here = sensor + offset.
struct ClockMapping {
  // Too large by the way of the quickest packet alone, which nobody knows; never too small, but for
  // the drift of two windows.
  std::int64_t offset_ns = 0;
  // By how much the ways of frames differed: what the network and both systems add at times.
  std::int64_t spread_ns = 0;
  Time newest{};  // frame that it was made of
};

// Each frame says when its first packet was sent, by the sensor's clock, and when that arrived is
// known here: the smallest difference of the last seconds is the quickest way. It follows clocks
// that drift by 200 ppm within 0.4 ms a window. No clock of its own.
class ClockMap {
 public:
  static constexpr Duration kWindow = std::chrono::seconds(2);

  // Of a frame that was delivered. One without info, of emulated or recorded time, or of which
  // nothing is known: does not count. Another session begins anew.
  void add(const Frame& frame) noexcept;

  // None: no frame has told it so far.
  std::optional<ClockMapping> mapping() const noexcept;
  // Whether the newest frame's stamps are of a clock that cannot be mapped: emulated, or recorded.
  bool unmappable() const noexcept { return unmappable_; }

 private:
  struct Window {
    std::int64_t least_ns = 0;
    std::int64_t most_ns = 0;
    bool used = false;
  };
  void turn(Time now) noexcept;

  std::uint32_t session_ = 0;
  bool unmappable_ = false;
  Time begun_{};  // the newer window
  Time newest_{};
  std::array<Window, 2> windows_{};  // the newer one first
};

}  // namespace stof::client
