#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

#include "dsp/base/arena.h"
#include "dsp/base/fixed.h"
#include "dsp/base/image.h"
#include "dsp/calib/calibration.h"
#include "dsp/calib/stereo/interval_tables.h"
#include "dsp/fusion/fuser.h"
#include "dsp/fusion/unwrap/count_votes.h"

namespace stof::dsp {

// Every step-th disparity as a depth interval [Z(d + 2 sigma), Z(d - 2 sigma)], up to 16.38 m
// whatever the range of the fusion: what lies beyond is evidence too.
class StereoSamples {
 public:
  // A picture of width x height; the step is the smallest power of two, 2 or more, of which kWindow
  // reach across `footprint` pixels.
  StereoSamples(const StereoRig& rig, std::int16_t sigma, int min_disparity, int disparities,
                int width, int height, double footprint, Arena& arena) noexcept;

  // disparity: as large as the constructor's size, or empty: nothing is known.
  void take(ImageView<const Disparity> disparity) noexcept;
  const SampleGrid& grid() const noexcept { return grid_; }

 private:
  void take_row(std::span<const Disparity> disparity, std::span<QuarterMm> low,
                std::span<QuarterMm> high) noexcept;
  void clear(std::size_t begin, std::size_t end) noexcept;

  SampleGrid grid_;
  IntervalTables tables_;
  std::span<QuarterMm> low_;  // with the border
  std::span<QuarterMm> high_;
  std::span<Disparity> some_;     // every step-th of a row
  std::span<std::uint8_t> half_;  // of a whole row: 2 sigma, 1/16 px
  std::span<QuarterMm> near_;     // of a whole row
  std::span<QuarterMm> far_;
};

}  // namespace stof::dsp
