#pragma once

#include <cstdint>

#include "dsp/base/arena.h"
#include "dsp/base/image.h"
#include "dsp/fusion/depth_map.h"
#include "dsp/fusion/sensor_intervals.h"
#include "dsp/fusion/temporal/picture_change.h"
#include "dsp/fusion/temporal/steady_filter.h"
#include "dsp/fusion/temporal/temporal_filter.h"

namespace stof::dsp {

// What earlier frames say about this one's map: first they decide what is published
// (steady_filter.h), then it is averaged (temporal_filter.h). Where the left picture changed, the
// past counts for nothing; where the camera moved, nowhere (picture_change.h), and while it goes on
// moving nothing is remembered: then only pictures are compared. 11.3 bytes a pixel.
class PastFrames {
 public:
  // threads: how many filter rows at the same time.
  PastFrames(int width, int height, QuarterMm max_range, Arena& arena, int threads = 1) noexcept;

  // A frame begins. left: the picture in whose axes its map is. Call it for every frame; forget()
  // after a gap. Without a picture nobody can tell what moved: that is a gap, too, and its map is
  // not filtered.
  void look(ImageView<const std::uint8_t> left) noexcept;
  void forget() noexcept;
  // Whether the map of this frame is filtered.
  bool filters() const noexcept { return memory_ != Memory::kNone; }
  // Then each of its rows, in any order; the same thread number not twice at the same time. said:
  // of this row and frame.
  void filter(int y, int thread, const SensorIntervals& said, const DepthMap& map) noexcept;

  // For how many frames, this one included, the camera stood: 1 where it began anew, 0 before the
  // first. At most 65535.
  std::uint16_t frames() const noexcept { return frames_; }

 private:
  enum class Memory : std::uint8_t { kNone, kBegins, kGoesOn };

  PictureChange change_;
  SteadyFilter steady_;
  TemporalFilter mean_;
  ImageView<std::uint8_t> marks_;  // a row for each thread
  ImageView<Cause> causes_;        // too, where the map has none
  Memory memory_ = Memory::kNone;  // of this frame
  std::uint16_t frames_ = 0;
};

}  // namespace stof::dsp
