#pragma once

#include <cstdint>
#include <span>

#include "dsp/base/fixed.h"
#include "dsp/base/target.h"

namespace stof::dsp {

// Depth interval, quarter mm; 0, 0 = none.
struct DepthInterval {
  QuarterMm low = 0;
  QuarterMm high = 0;
};

// The interval of each raw disparity first_raw, first_raw + 1, ...; the last entry stands for every
// other disparity and for none. 1 to 65536 entries.
struct DisparityTable {
  std::int16_t first_raw = 0;
  std::span<const DepthInterval> intervals;
};

// low[x], high[x] = table's entry of disparity[x]. Equal lengths, any length, any alignment; no
// overlap.
using StereoInterval = void(std::span<const Disparity> disparity, const DisparityTable& table,
                            std::span<QuarterMm> low, std::span<QuarterMm> high) noexcept;
namespace ref {
StereoInterval stereo_interval;
}
namespace neon {
StereoInterval stereo_interval;
}

}  // namespace stof::dsp
