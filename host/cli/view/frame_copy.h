#pragma once

#include "dataset/dataset.h"
#include "host/client/frame/frame.h"
#include "host/evaluate/fusion/depth_score.h"
#include "host/picture/colour_scale.h"

namespace stof::host {

// A copy of a received frame that outlives the receiver's views; without the raw samples and the
// cloud.
class FrameCopy {
 public:
  void keep(const client::Frame& frame);
  bool empty() const noexcept { return frame_.packets == 0; }
  bool has_depth() const noexcept { return !depth_.pixels.empty(); }
  // Views into this object. Not for an empty one.
  client::Frame frame() const;
  // Not without depth. A width that was not sent is 0.
  DepthPlanes planes() const;

  // Writes depth_0000000042.png (16 bit) and depth_color_0000000042.png, named by the frame's
  // number. Not without depth. Throws Failure.
  void write_depth(const std::filesystem::path& folder, const ColourScale& scale) const;
  // Writes the images that there are into the folder, which is made where missing: depth.png (16
  // bit, quarter millimetres), depth_color.png and cloud.ply, source.png, disparity.png, left.png,
  // right.png. Returns one line that says what was written, or why no cloud could be. Throws
  // Failure.
  std::string write(const std::filesystem::path& folder, const ColourScale& scale) const;

 private:
  client::Frame frame_;  // without its views
  dataset::Image<dsp::QuarterMm> depth_;
  dataset::Image<dsp::QuarterMm> width_;
  dataset::Image<dsp::Source> source_;
  dataset::Image<std::uint8_t> received_;
  dataset::Image<dsp::Disparity> disparity_;
  dataset::Image<std::uint8_t> left_;
  dataset::Image<std::uint8_t> right_;
};

}  // namespace stof::host
