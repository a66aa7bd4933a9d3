#pragma once

#include <cstdint>
#include <span>

#include "dsp/base/fixed.h"
#include "dsp/base/kernel.h"

namespace stof::dsp {

// Depth interval, quarter mm; 0, 0 = none.
struct DepthInterval {
  QuarterMm low = 0;
  QuarterMm high = 0;
};

// The widest half of an interval, 1/16 px.
inline constexpr int kMostHalfWidth = 255;

// Z of raw disparities: bounds[k] belongs to first_raw - kMostHalfWidth + k and is rounded down and
// up, low at least 1, high at most max_range, which also stands for infinity and what lies behind
// it; low saturates at 65535. The last disparity is first_raw + size - 1 - 2 kMostHalfWidth; 511 to
// 65536 entries.
struct DisparityTable {
  std::int16_t first_raw = 0;
  QuarterMm max_range = 0;
  std::span<const DepthInterval> bounds;

  // Number of disparities.
  constexpr int size() const noexcept {
    return static_cast<int>(bounds.size()) - 2 * kMostHalfWidth;
  }
  // [Z(raw + half), Z(raw - half)]; 0, 0 where the near end reaches max_range and for a raw
  // disparity outside of the table. half in 0 .. kMostHalfWidth.
  constexpr DepthInterval at(int raw, int half) const noexcept {
    const int step = raw - first_raw;
    if (step < 0 || step >= size()) {
      return {};
    }
    const QuarterMm near = bounds[static_cast<std::size_t>(step + kMostHalfWidth + half)].low;
    const QuarterMm far = bounds[static_cast<std::size_t>(step + kMostHalfWidth - half)].high;
    return near < max_range ? DepthInterval{near, far} : DepthInterval{};
  }
};

// low[x], high[x] = table.at(raw, half[x]): [Z(d + 2 sigma), Z(d - 2 sigma)] where half is 2 sigma
// in 1/16 px; 0, 0 without disparity. Equal lengths, any length, any alignment; no overlap.
using StereoInterval = void(std::span<const Disparity> disparity,
                            std::span<const std::uint8_t> half, const DisparityTable& table,
                            std::span<QuarterMm> low, std::span<QuarterMm> high) noexcept;
STOF_KERNEL(StereoInterval, stereo_interval, kAvx2)

}  // namespace stof::dsp
