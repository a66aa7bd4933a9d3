#pragma once

#include <chrono>
#include <cstdint>
#include <optional>

#include "firmware/update/shown.h"
#include "hal/time.h"

namespace stof::update {

// A slot on trial: it is confirmed when for kProof without a gap it published what the sensor
// published before the restart, and left when that has not come in time. A kind that was not there
// before (a broken camera) blocks nothing; the rounds of the loop always count, so that a start of
// the program alone confirms nothing. A program that crashes or hangs never comes to the end of it:
// the next start takes the other slot by itself. No heap, no clock of its own.
class Trial {
 public:
  static constexpr hal::Duration kProof = std::chrono::seconds(30);
  // Beyond three gaps.
  static constexpr hal::Duration kLimit = std::chrono::seconds(57);
  static constexpr hal::Duration kLeastGap = std::chrono::seconds(3);

  enum class Verdict : std::uint8_t { kOpen, kConfirmed, kLeft };

  // The longest time between two frames of a sensor that is well.
  static constexpr hal::Duration gap_of(hal::Duration period) noexcept {
    return 3 * period > kLeastGap ? 3 * period : kLeastGap;
  }

  explicit Trial(Shown before) noexcept : needed_(static_cast<Shown>(before | kRoundsAlone)) {}

  // Several times a second. A verdict stays.
  Verdict tick(hal::Time now, const Published& published, hal::Duration period) noexcept;

 private:
  Shown needed_;
  ShownLately lately_;
  std::optional<hal::Time> begun_;
  std::optional<hal::Time> since_;  // all that is needed has come without a gap
  Verdict verdict_ = Verdict::kOpen;
};

}  // namespace stof::update
