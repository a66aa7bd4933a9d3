#pragma once

#include <chrono>
#include <cstdint>

#include "firmware/wire/frame_info.h"
#include "host/client/frame/frame.h"

namespace stof::client {

// No sensor takes a longer period (setting period_ms).
inline constexpr Duration kLongestPeriod = std::chrono::seconds(60);

constexpr bool is_period(std::int64_t period_ns) noexcept {
  return period_ns >= 0 && std::chrono::nanoseconds(period_ns) <= kLongestPeriod;
}

// What a frame says that it was made with.
struct MadeWith {
  std::uint32_t session = 0;
  std::uint32_t settings = 0;     // their revision
  std::uint32_t calibration = 0;  // its fingerprint
  // Zeros: told by calibration messages alone, as older sensors do.
  std::uint32_t max_range_um = 0;
  Duration period{0};

  friend bool operator==(const MadeWith&, const MadeWith&) = default;
};

constexpr MadeWith made_with(std::uint32_t session, const wire::FrameInfo& info) noexcept {
  const std::int64_t period_ns = is_period(info.period_ns) ? info.period_ns : 0;
  return {.session = session,
          .settings = info.settings_revision,
          .calibration = info.calibration_fingerprint,
          .max_range_um = info.max_range_um,
          .period = std::chrono::nanoseconds(period_ns)};
}

}  // namespace stof::client
