#pragma once

#include "dataset/dataset.h"
#include "host/client/frame.h"
#include "host/evaluate/depth_score.h"
#include "host/picture/colour_scale.h"

namespace stof::host {

// A copy of a received frame that outlives the receiver's views.
class KeptFrame {
 public:
  void keep(const client::Frame& frame);
  bool empty() const noexcept { return depth_.pixels.empty(); }
  // Views into this object. Not for an empty one.
  client::Frame frame() const;
  DepthPlanes planes() const;

  // Writes depth.png (16 bit, quarter millimetres), depth_color.png and cloud.ply into the folder,
  // which is made where missing. Returns one line that says what was written, or why no cloud could
  // be. Throws Failure.
  std::string write(const std::filesystem::path& folder, const ColourScale& scale) const;

 private:
  client::Frame frame_;  // its views are the receiver's and not used
  dataset::Image<dsp::QuarterMm> depth_;
  dataset::Image<dsp::QuarterMm> width_;
  dataset::Image<dsp::Source> source_;
  dataset::Image<std::uint8_t> received_;
};

}  // namespace stof::host
