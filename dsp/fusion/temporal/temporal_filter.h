#pragma once

#include <cstdint>
#include <span>

#include "dsp/base/arena.h"
#include "dsp/base/fixed.h"
#include "dsp/base/image.h"
#include "dsp/fusion/depth_map.h"
#include "dsp/fusion/temporal/temporal_row.h"

namespace stof::dsp {

// The defaults of TemporalLimits at 30 frames a second:
//   frames 8        a quarter of a second; noise falls to a third, the next third would take 72
//   max_step 1200   0.3 m: 3 sigma of a reading with a sigma of 0.1 m; noisier ones begin anew more
//                   often
using TemporalParams = TemporalLimits;

// Averages a depth map over frames where nothing moved. Per pixel (temporal_row.h has the formula):
//
//   * No blend across motion. A mean goes on only while depth stays within 3 sigma of it (width = 4
//     sigma), the left picture did not change around it, and the source is the same; else the
//     measurement is published as it is. So is a mean of fewer than four frames.
//   * Nothing is held over: no depth in, no depth out, and the mean is gone.
//   * Lag. The published depth is never further than width / 4 (one sigma) from this frame's own,
//     so always in the middle half of this frame's interval, whatever moves. Residuals of more than
//     width / 8 on one side, three in a row: the measurement is published; four: the mean begins
//     anew. Without noise a surface faster than width / 8 a frame is therefore published without
//     any lag.
//   * Width falls only by what the pixel was seen to scatter, at most to half, and not before 8
//     frames: errors that stay (matching, wiggling, calibration) do not scatter. With S = 2 sigma
//     of the noise seen, what is left of half the width is sqrt(half^2 - 7/8 S^2); half * 7 / 4 - S
//     is above that for every S. The published interval always holds this frame's depth.
//
// Measured with intervals that hold the truth 95 times in 100: noise alone and noise with a
// constant error of width / 4 are held at least as often afterwards; a noisy surface that creeps by
// a sixteenth of its width a frame, 93 times. Noise of half of what width says falls to a third,
// noise of all of it to 0.55, since the mean may not leave a frame's own depth by more than width
// / 4.
//
// Not promised: that a displacement within the noise, without a change in the picture, is seen at
// once; that a reading which the camera repeats (a PMD slower than the pictures) counts once.
// Sources and causes stay as they are. 6 bytes a pixel.
class TemporalFilter {
 public:
  // params.frames 1 .. kMostFrames, params.max_step <= kMostStep. Maps of this size.
  TemporalFilter(int width, int height, const TemporalParams& params, Arena& arena) noexcept;

  // Filters depth and width of a row of a frame in place. marks: as PictureChange has them.
  void filter(int y, std::span<const std::uint8_t> marks, const DepthMap& map) noexcept;

 private:
  TemporalParams params_;
  ImageView<QuarterMm> mean_;
  ImageView<std::uint16_t> scatter_;
  ImageView<std::uint8_t> tally_;
  ImageView<std::uint8_t> kind_;
};

}  // namespace stof::dsp
