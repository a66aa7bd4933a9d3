#include "dsp/pmd/phase/merge_exposures.h"

#include <algorithm>
#include <cstddef>

#include "dsp/base/check.h"
#include "dsp/pmd/pmd_maps.h"

namespace stof::dsp {

void check_merge_exposures(const ExposureRow& shorter, const ExposureRow& merged,
                           std::size_t n) noexcept {
  for (const ExposureRow* row : {&shorter, &merged}) {
    STOF_CHECK(row->phase.size() == n && row->amp2.size() == n && row->offset.size() == n);
    STOF_CHECK(row->flags.size() == n);
  }
  STOF_CHECK(shorter.ratio.size() == merged.ratio.size());
  STOF_CHECK(shorter.ratio.empty() || shorter.ratio.size() == n);
  STOF_CHECK(shorter.sigma.size() == merged.sigma.size());
  STOF_CHECK(shorter.sigma.empty() || shorter.sigma.size() == n);
}

namespace ref {
namespace {

constexpr int kGainBits = 8;

std::uint16_t brighter(std::uint16_t value, std::uint32_t gain_q8) noexcept {
  return static_cast<std::uint16_t>(
      std::min<std::uint32_t>(round_shift(value * gain_q8, kGainBits), 65535));
}

}  // namespace

void merge_exposures(const ExposureRow& shorter, std::uint8_t index, std::uint16_t gain_q8,
                     const ExposureRow& merged, std::span<std::uint8_t> taken) noexcept {
  const std::size_t n = taken.size();
  check_merge_exposures(shorter, merged, n);
  for (std::size_t x = 0; x < n; ++x) {
    if ((merged.flags[x] & kPmdSaturated) == 0) {
      continue;
    }
    merged.phase[x] = shorter.phase[x];
    merged.amp2[x] = brighter(shorter.amp2[x], gain_q8);
    merged.offset[x] = brighter(shorter.offset[x], gain_q8);
    merged.flags[x] = shorter.flags[x];
    if (!merged.ratio.empty()) {
      merged.ratio[x] = shorter.ratio[x];
    }
    if (!merged.sigma.empty()) {
      merged.sigma[x] = shorter.sigma[x];
    }
    taken[x] = index;
  }
}

}  // namespace ref
}  // namespace stof::dsp
