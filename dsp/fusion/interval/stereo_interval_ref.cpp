#include "dsp/fusion/interval/stereo_interval.h"

#include <cstddef>

#include "dsp/base/check.h"

namespace stof::dsp::ref {

void stereo_interval(std::span<const Disparity> disparity, std::span<const std::uint8_t> half,
                     const DisparityTable& table, std::span<QuarterMm> low,
                     std::span<QuarterMm> high) noexcept {
  STOF_CHECK(half.size() == disparity.size() && low.size() == disparity.size() &&
             high.size() == disparity.size());
  STOF_CHECK(table.size() >= 1);
  for (std::size_t x = 0; x < disparity.size(); ++x) {
    const DepthInterval interval =
        disparity[x].valid() ? table.at(disparity[x].raw, half[x]) : DepthInterval{};
    low[x] = interval.low;
    high[x] = interval.high;
  }
}

}  // namespace stof::dsp::ref
