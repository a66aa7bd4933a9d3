#include "dsp/pmd/range/emitter_offset.h"

#include <algorithm>
#include <cstddef>

#include "dsp/base/check.h"
#include "dsp/base/fixed.h"
#include "dsp/pmd/range/phase_to_distance.h"

namespace stof::dsp::ref {
namespace {

constexpr float kLargestBend = 1048576.0F;
constexpr int kQuarterBits = 2;

// Nearest integer to `v`, ties to even, for |v| <= 2^20.
int nearest_even(float v) noexcept { return static_cast<int>(v + 12582912.0F) - 12582912; }

}  // namespace

void emitter_offset(const EmitterOffsetRow& table, std::uint32_t shortest,
                    std::span<std::uint32_t> distance) noexcept {
  const std::size_t n = distance.size();
  STOF_CHECK(table.half_q2.size() == n && table.twice_area.size() == n && table.pole.size() == n);
  STOF_CHECK(shortest <= 2 * kMostUnits);
  for (std::size_t x = 0; x < n; ++x) {
    const std::uint32_t measured = std::min(distance[x], kMostUnits);
    const int way = static_cast<int>(std::max(2 * measured, shortest));
    const int free_way = std::max(way - table.pole[x], 1);
    const float bend = static_cast<float>(table.twice_area[x]) / static_cast<float>(free_way);
    const int quarters = static_cast<int>(4 * measured) + table.half_q2[x] -
                         nearest_even(std::clamp(bend, -kLargestBend, kLargestBend));
    distance[x] = static_cast<std::uint32_t>(std::max(round_shift(quarters, kQuarterBits), 1));
  }
}

}  // namespace stof::dsp::ref
