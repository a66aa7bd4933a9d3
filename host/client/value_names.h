#pragma once

#include <array>
#include <cstddef>

#include "firmware/wire/packet.h"

// Names of values of the wire format in the library, JSON and the command line, in their order.
namespace stof::client {

inline constexpr std::array kSourceNames{"none", "stereo", "pmd", "both", "resolved", "conflict"};
inline constexpr std::array kCauseNames{
    "none",     "mixed_pixel",   "stereo_ambiguous", "range_ambiguous",
    "occluded", "contradiction", "interpolated"};
inline constexpr std::array kHealthNames{"ok", "degraded", "fault"};

// "unknown" for a value that only a newer sensor knows.
template <std::size_t kCount>
constexpr const char* name_in(const std::array<const char*, kCount>& names,
                              std::size_t value) noexcept {
  return value < kCount ? names[value] : "unknown";
}

// Whose clock the stamps count by.
constexpr const char* clock_text(wire::ClockState clock) noexcept {
  switch (clock) {
    case wire::ClockState::kMonotonic:
      return "monotonic, of the sensor";
    case wire::ClockState::kEmulated:
      return "emulated";
    case wire::ClockState::kRecorded:
      return "of a recording that was played again";
  }
  return "unknown";
}

}  // namespace stof::client
