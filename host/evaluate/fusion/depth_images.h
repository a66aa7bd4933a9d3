#pragma once

#include "dataset/dataset.h"
#include "dsp/fusion/depth_map.h"
#include "dsp/pmd/converter.h"
#include "host/evaluate/fusion/depth_score.h"

namespace stof::host {

// What a DepthMaker writes.
struct DepthImages {
  dataset::Image<dsp::QuarterMm> depth;
  dataset::Image<dsp::QuarterMm> width;
  dataset::Image<dsp::Source> source;
  dataset::Image<dsp::Cause> cause;

  DepthImages(int w, int h) : depth(w, h), width(w, h), source(w, h), cause(w, h) {}
  dsp::DepthMap map() { return {depth.view(), width.view(), source.view(), cause.view()}; }
  DepthPlanes planes() const { return to_metres(depth.view(), width.view()); }
};

// A recording's first frame as a DepthMaker takes it.
class FirstFrame {
 public:
  explicit FirstFrame(const dataset::PmdRecording& recording) : first_{recording.samples(0)} {
    frame_.first = {&first_, 1};
    if (!recording.second_frames.empty()) {
      second_.samples = recording.second_samples(0);
      frame_.second = {&second_, 1};
    }
  }
  FirstFrame(const FirstFrame&) = delete;
  FirstFrame& operator=(const FirstFrame&) = delete;
  const dsp::PmdFrame& frame() const { return frame_; }

 private:
  dsp::PmdExposure first_;
  dsp::PmdExposure second_;
  dsp::PmdFrame frame_;
};

}  // namespace stof::host
