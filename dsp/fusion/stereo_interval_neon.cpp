#include "dsp/fusion/stereo_interval.h"

#include <array>
#include <cstddef>

#include "dsp/base/check.h"
#include "dsp/base/simd.h"

namespace stof::dsp::neon {

void stereo_interval(std::span<const Disparity> disparity, const DisparityTable& table,
                     std::span<QuarterMm> low, std::span<QuarterMm> high) noexcept {
  constexpr std::size_t kLanes = 8;
  STOF_CHECK(low.size() == disparity.size() && high.size() == disparity.size());
  STOF_CHECK(!table.intervals.empty() && table.intervals.size() <= 65536);
  const uint16x8_t last = vdupq_n_u16(static_cast<std::uint16_t>(table.intervals.size() - 1));
  const int16x8_t first = vdupq_n_s16(table.first_raw);
  const int16x8_t none = vdupq_n_s16(Disparity::none().raw);
  std::size_t x = 0;
  for (; x + kLanes <= disparity.size(); x += kLanes) {
    const int16x8_t raw = vld1q_s16(&disparity[x].raw);
    // A disparity below the first wraps to a large step, and so to the last entry.
    const uint16x8_t step = vreinterpretq_u16_s16(vsubq_s16(raw, first));
    const uint16x8_t outside = vorrq_u16(vcltq_s16(raw, first), vceqq_s16(raw, none));
    std::array<std::uint16_t, kLanes> index{};
    vst1q_u16(index.data(), vminq_u16(vorrq_u16(step, outside), last));
    for (std::size_t k = 0; k < kLanes; ++k) {  // NEON has no gather
      const DepthInterval interval = table.intervals[index[k]];
      low[x + k] = interval.low;
      high[x + k] = interval.high;
    }
  }
  ref::stereo_interval(disparity.subspan(x), table, low.subspan(x), high.subspan(x));
}

}  // namespace stof::dsp::neon
