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
  // By value: no store of a byte can change them.
  const WrapMaps m = maps;
  const std::span<QuarterMm> distance = distance_;
  const std::span<std::int8_t> wraps = wraps_;
  const std::span<std::uint8_t> kept = votes_;
  for (std::size_t i = 0; i < kept.size(); ++i) {
    const std::int8_t now = m.wraps[i];
    if (now == kNoReading) {
      continue;
    }
    const Reading& reading = m.readings[i];
    int votes = is_same_reading(reading.distance, reading.sigma, distance[i]) ? kept[i] : 0;
    const std::int8_t known = wraps[i];
    distance[i] = reading.distance;
    if (now == known && votes == kMost) {  // most of them
      continue;
    }
    if (now < 0) {
      const bool keeps =
          votes >= kEnough && has_bit(m.possible, i, known) && !has_bit(m.mixed, i, known);
      m.wraps[i] = keeps ? known : now;
      votes = std::max(votes - 1, 0);
    } else if (votes == 0 || now == known) {
      wraps[i] = now;
      votes = std::min(votes + kDecided, kMost);
    } else {
      votes = std::max(votes - kDecided, 0);
      m.wraps[i] = votes >= kEnough ? kDisputedWraps : now;
    }
    kept[i] = static_cast<std::uint8_t>(votes);
  }
}

}  // namespace stof::dsp
