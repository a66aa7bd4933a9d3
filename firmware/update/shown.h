#pragma once

#include <array>
#include <cstdint>

#include "hal/time.h"

namespace stof::update {

// Counters of a running sensor; they only rise.
struct Published {
  std::uint64_t rounds = 0;  // of the loop, with a frame or without
  std::uint64_t frames = 0;
  std::uint64_t with_pair = 0;  // frames that stand on the pair
  std::uint64_t with_pmd = 0;   // frames that stand on the PMD camera
  bool standby = false;         // there are none now, as the settings want
};
inline constexpr std::size_t kKinds = 4;

// A set of kinds of Published; bit 0: rounds.
using Shown = std::uint8_t;
inline constexpr Shown kRoundsAlone = 1;
inline constexpr Shown kAllShown = 15;

// When each kind rose last.
class ShownLately {
 public:
  void note(hal::Time now, const Published& published) noexcept {
    const std::array<std::uint64_t, kKinds> counts{published.rounds, published.frames,
                                                   published.with_pair, published.with_pmd};
    for (std::size_t i = 0; i < kKinds; ++i) {
      if (counts[i] > counts_[i]) {
        counts_[i] = counts[i];
        rose_[i] = now;
        ever_ = static_cast<Shown>(ever_ | 1U << i);
      }
    }
  }
  // Those that rose in the last `span`.
  Shown within(hal::Time now, hal::Duration span) const noexcept {
    Shown shown = 0;
    for (std::size_t i = 0; i < kKinds; ++i) {
      const bool lately = (ever_ >> i & 1U) != 0 && now - rose_[i] <= span;
      shown = static_cast<Shown>(shown | (lately ? 1U : 0U) << i);
    }
    return shown;
  }

 private:
  std::array<std::uint64_t, kKinds> counts_{};
  std::array<hal::Time, kKinds> rose_{};
  Shown ever_ = 0;
};

}  // namespace stof::update
