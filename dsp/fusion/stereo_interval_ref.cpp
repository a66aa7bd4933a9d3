#include "dsp/fusion/stereo_interval.h"

#include <cstddef>

#include "dsp/base/check.h"

namespace stof::dsp::ref {

void stereo_interval(std::span<const Disparity> disparity, const DisparityTable& table,
                     std::span<QuarterMm> low, std::span<QuarterMm> high) noexcept {
  STOF_CHECK(low.size() == disparity.size() && high.size() == disparity.size());
  STOF_CHECK(!table.intervals.empty());
  const int known = static_cast<int>(table.intervals.size()) - 1;
  for (std::size_t x = 0; x < disparity.size(); ++x) {
    const int step = disparity[x].raw - table.first_raw;
    const bool inside = disparity[x].valid() && step >= 0 && step < known;
    const DepthInterval interval = table.intervals[static_cast<std::size_t>(inside ? step : known)];
    low[x] = interval.low;
    high[x] = interval.high;
  }
}

}  // namespace stof::dsp::ref
