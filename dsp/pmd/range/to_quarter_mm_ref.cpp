#include "dsp/pmd/range/to_quarter_mm.h"

#include <algorithm>
#include <cstddef>

#include "dsp/base/check.h"
#include "dsp/pmd/pmd_maps.h"
#include "dsp/pmd/range/phase_to_distance.h"

namespace stof::dsp::ref {

void to_quarter_mm(std::span<std::uint32_t> reading, std::uint32_t unit_q30,
                   std::span<std::uint8_t> flags, std::span<QuarterMm> distance,
                   std::span<QuarterMm> sigma) noexcept {
  const std::size_t n = reading.size();
  STOF_CHECK(flags.size() == n && distance.size() == n && sigma.size() == n);
  STOF_CHECK(unit_q30 <= kQuarterMmQ30);
  for (std::size_t x = 0; x < n; ++x) {
    const bool missing = (flags[x] & kPmdMissing) != 0;
    const std::uint32_t units = std::clamp(reading[x], std::uint32_t{1}, kMostUnits);
    const std::uint64_t quarters =
        std::max<std::uint64_t>(round_shift(std::uint64_t{units} * unit_q30, 30), 1);
    const bool far = quarters > kMaxQuarterMm;
    reading[x] = missing ? 0 : units;
    distance[x] = static_cast<QuarterMm>(missing || far ? kNoDepth : quarters);
    sigma[x] = missing || far ? QuarterMm{0} : sigma[x];
    if (far && !missing) {
      flags[x] = static_cast<std::uint8_t>(flags[x] | kPmdOutOfRange);
    }
  }
}

}  // namespace stof::dsp::ref
