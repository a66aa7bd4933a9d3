#include "dsp/fusion/unwrap/decision/wrap_memory.h"

#include <algorithm>

#include "dsp/pmd/reading_memory.h"

namespace stof::dsp {
WrapMemory::WrapMemory(std::size_t pixels, Arena& arena) noexcept
    : distance_(arena.take_filled(pixels, kNoDepth)),
      wraps_(arena.take_filled(pixels, std::int8_t{0})),
      votes_(arena.take_filled(pixels, std::uint8_t{0})) {}

void WrapMemory::forget() noexcept { std::ranges::fill(votes_, std::uint8_t{0}); }

void WrapMemory::steady(const WrapMaps& maps) noexcept {
  for (std::size_t i = 0; i < votes_.size(); ++i) {
    const std::int8_t now = maps.wraps[i];
    if (now == kNoReading) {
      continue;
    }
    const Reading& reading = maps.readings[i];
    int votes = is_same_reading(reading.distance, reading.sigma, distance_[i]) ? votes_[i] : 0;
    const std::int8_t known = wraps_[i];
    distance_[i] = reading.distance;
    if (now < 0) {
      const bool keeps =
          votes >= kEnough && has_bit(maps.possible, i, known) && !has_bit(maps.mixed, i, known);
      maps.wraps[i] = keeps ? known : now;
      votes = std::max(votes - 1, 0);
    } else if (votes == 0 || now == known) {
      wraps_[i] = now;
      votes = std::min(votes + kDecided, kMost);
    } else {
      votes = std::max(votes - kDecided, 0);
      maps.wraps[i] = votes >= kEnough ? kDisputedWraps : now;
    }
    votes_[i] = static_cast<std::uint8_t>(votes);
  }
}

}  // namespace stof::dsp
