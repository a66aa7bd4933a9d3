#pragma once

#include <array>
#include <cstdint>
#include <span>

#include "dsp/base/fixed.h"
#include "dsp/base/kernel.h"
#include "dsp/fusion/depth_map.h"

namespace stof::dsp {

// The state of each pixel of a row, 6 bytes. All zero: none.
struct TemporalState {
  std::span<QuarterMm> mean;         // whole quarter mm of the mean depth
  std::span<std::uint16_t> scatter;  // mean |residual|, 4 fraction bits
  std::span<std::uint8_t> tally;     // bits 0-3 frames in the mean, 4-7 fraction of the mean
  std::span<std::uint8_t> kind;  // bits 0-2 Source, 3-4 run, 5 the run goes away from the camera
};

struct TemporalRow {
  std::span<const std::uint8_t> changed;  // not 0: the picture has changed there
  std::span<const Source> source;
  std::span<QuarterMm> depth;
  std::span<QuarterMm> width;
};

// 32768 / n to the nearest, n = 1..15, at most 32767; its low and high bytes.
struct Reciprocals {
  std::array<std::uint8_t, 16> low;
  std::array<std::uint8_t, 16> high;
};
inline constexpr Reciprocals kReciprocals = [] {
  Reciprocals table{};
  for (int n = 1; n < 16; ++n) {
    const int rounded = (2 * kQ15One + n) / (2 * n);
    const int value = rounded < kQ15One ? rounded : kQ15One - 1;
    table.low[static_cast<std::size_t>(n)] = static_cast<std::uint8_t>(value % 256);
    table.high[static_cast<std::size_t>(n)] = static_cast<std::uint8_t>(value / 256);
  }
  return table;
}();

struct TemporalLimits {
  std::uint8_t frames = 8;    // 1 .. kMostFrames
  QuarterMm max_step = 1200;  // 0 .. kMostStep
};
inline constexpr std::uint8_t kMostFrames = 15;
inline constexpr QuarterMm kMostStep = 2000;  // with 4 fraction bits it fits int16

inline constexpr int kFramesToAverage = 4;  // a mean of fewer is not published
inline constexpr int kFramesToNarrow = 8;   // fewer do not tell how much noise there is
inline constexpr int kRestartRun = 4;
inline constexpr int kMeanBits = 4;
inline constexpr int kMeanOne = 1 << kMeanBits;

// One frame of a row. With half = width / 2 (2 sigma), r = depth - whole quarter mm of mean:
//   a residual is far where |r| > half / 4; run = far residuals in a row with the sign of this one
//   the mean goes on where there is a depth and a mean, the source is the same, the picture has
//     not changed, |r| <= min(half * 3 / 2, max_step), and run < kRestartRun;
//     else it begins with this depth, which is published as it is; without a depth it ends
//   n = min(frames in the mean + 1, frames)
//   mean += (depth - mean) / n
//   scatter += (|r| - scatter) / (n before)
//   half' = half * 7 / 4 - scatter * 19 / 8, within half / 2 .. half, where n >= kFramesToNarrow
//     and run < 2; else half
//   published where n >= kFramesToAverage and run < kRestartRun - 1: the mean, but within half / 2
//     of this depth, and not so near 0 or 65535 that depth -+ half' leaves u16 where this depth's
//     would not; else this depth
//   width -= 2 (half - half')
// Every quotient is rounded down; products with kReciprocals to the nearest, halves up. Equal
// lengths, any length, any alignment; no overlap. State: of earlier calls with the same limits, or
// anything where the picture has changed.
using TemporalRowKernel = void(const TemporalRow& row, const TemporalLimits& limits,
                               const TemporalState& state) noexcept;

STOF_KERNEL(TemporalRowKernel, temporal_row, kAvx512)

// Lengths and limits as above.
void check_temporal_row(const TemporalRow& row, const TemporalLimits& limits,
                        const TemporalState& state) noexcept;

}  // namespace stof::dsp
