#include "dsp/pmd/range/phase_to_distance.h"

#include <algorithm>
#include <cstddef>

#include "dsp/base/check.h"

namespace stof::dsp::ref {

void phase_to_distance(std::span<const Phase> phase, std::uint32_t turn,
                       std::span<std::uint32_t> distance) noexcept {
  STOF_CHECK(distance.size() == phase.size() && turn <= kMostUnits);
  for (std::size_t x = 0; x < phase.size(); ++x) {
    distance[x] = static_cast<std::uint32_t>(round_shift(std::uint64_t{phase[x]} * turn, 16));
  }
}

void correct_distance(const LinearDistanceCorrection& line,
                      std::span<std::uint32_t> distance) noexcept {
  STOF_CHECK(usable(line));
  for (std::uint32_t& d : distance) {
    const std::uint64_t stretched =
        round_shift(std::uint64_t{std::min(d, kMostUnits)} * line.scale_q15, kQ15Bits);
    std::int64_t z = static_cast<std::int64_t>(stretched) + line.shift;
    z = z <= 0 ? z + line.turn : z;
    d = static_cast<std::uint32_t>(std::clamp<std::int64_t>(z, 1, kMostUnits));
  }
}

}  // namespace stof::dsp::ref
