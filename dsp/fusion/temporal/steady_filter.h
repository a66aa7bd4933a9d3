#pragma once

#include <cstdint>
#include <span>

#include "dsp/base/arena.h"
#include "dsp/base/image.h"
#include "dsp/fusion/depth_map.h"
#include "dsp/fusion/sensor_intervals.h"
#include "dsp/fusion/temporal/steady_row.h"

namespace stof::dsp {

// Evidence of earlier frames decides source and validity where nothing moved (steady_row.h has the
// rule): a reading that was doubted is published where it confirms what was seen there, and a depth
// that contradicts it is not, until it was seen for some frames or both sensors say so.
//
//   * No depth without a reading of this frame: what is published lies in an interval of it, or is
//     a guess of this frame.
//   * What has left is published no longer than its sensors see it, and what comes is published at
//     once where the picture shows it, else after three frames at most.
//
// 3 bytes a pixel.
class SteadyFilter {
 public:
  SteadyFilter(int width, int height, QuarterMm max_range, Arena& arena) noexcept;

  // A row of a frame. marks: as PictureChange has them.
  void filter(int y, std::span<const std::uint8_t> marks, const SensorIntervals& said,
              const FusedRow& fused) noexcept;

 private:
  SteadyLimits limits_;
  ImageView<QuarterMm> seen_;
  ImageView<std::uint8_t> tally_;
};

}  // namespace stof::dsp
