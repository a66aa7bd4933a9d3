#pragma once

#include <cstdint>
#include <string_view>
#include <vector>

#include "dataset/dataset.h"
#include "dsp/base/fixed.h"
#include "dsp/fusion/depth_map.h"
#include "firmware/wire/frame/frame_images.h"

namespace stof::test {

// Every image of one frame of the emulated corridor, 640x480, matched with a preset and fused as
// the appliance does it. Takes about a second.
class CorridorFrame {
 public:
  explicit CorridorFrame(std::string_view preset = "fast");

  wire::FrameImages images() noexcept;
  wire::FrameSizes sizes() const noexcept;

 private:
  dataset::Image<std::uint8_t> left_;
  dataset::Image<std::uint8_t> right_;
  std::vector<dataset::Image<std::uint16_t>> samples_;
  dataset::Image<dsp::QuarterMm> depth_;
  dataset::Image<dsp::QuarterMm> width_;
  dataset::Image<dsp::Source> source_;
  dataset::Image<dsp::Cause> cause_;
  dataset::Image<dsp::Disparity> disparity_;
};

}  // namespace stof::test
