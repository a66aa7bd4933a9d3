#pragma once

#include <cstdint>

#include "dsp/base/arena.h"
#include "dsp/base/image.h"
#include "dsp/fusion/depth_map.h"
#include "dsp/fusion/fuser.h"
#include "dsp/fusion/temporal/picture_change.h"
#include "dsp/fusion/temporal/steady_row.h"

namespace stof::dsp {

// Evidence of earlier frames decides source and validity where nothing moved (steady_row.h has the
// rule): a reading that was doubted is published where it confirms what was seen there, and a depth
// that contradicts it is not, until it was seen for some frames or both sensors say so. Where the
// left picture changed, or the camera moved, the past counts for nothing (picture_change.h).
//
//   * No depth without a reading of this frame: what is published lies in an interval of it.
//   * What has left is published no longer than its sensors see it, and what comes is published at
//     once where the picture shows it, else after three frames at most.
//
// 4.1 bytes a pixel.
class SteadyFilter final : public FusedRowFilter {
 public:
  // threads: how many filter rows at the same time.
  SteadyFilter(int width, int height, QuarterMm max_range, Arena& arena, int threads = 1) noexcept;

  // A frame begins. left: the picture in whose axes its map is. Call it for every frame; forget()
  // after a gap, or where there is no picture.
  void look(ImageView<const std::uint8_t> left) noexcept;
  void forget() noexcept;
  // Then each of its rows, in any order.
  void filter(int y, int thread, const IntervalRow& stereo, const IntervalRow& pmd,
              const FusedRow& fused) noexcept override;

  // Of the last picture.
  const PictureChange& change() const noexcept { return change_; }

  // For how many frames, this one included, the camera stood: 1 where it began anew, 0 before the
  // first. At most 65535.
  std::uint16_t frames() const noexcept { return frames_; }

 private:
  void begin() noexcept;

  SteadyLimits limits_;
  PictureChange change_;
  ImageView<QuarterMm> seen_;
  ImageView<std::uint8_t> tally_;
  ImageView<std::uint8_t> changed_;  // a row for each thread
  std::uint16_t frames_ = 0;
};

}  // namespace stof::dsp
