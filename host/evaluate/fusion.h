#pragma once

#include "dataset/dataset.h"
#include "host/evaluate/depth_score.h"
#include "host/evaluate/match.h"

namespace stof::host {

// Depth of one scene from each sensor alone and from both, in the left view.
struct FusionResult {
  DepthPlanes pmd;     // nothing of the stereo pair in it
  DepthPlanes stereo;  // the left-right-checked, unfilled map that enters the fusion
  DepthPlanes fused;
  double match_ms = 0;  // medians
  double convert_ms = 0;
  double fuse_ms = 0;
};

// The scene's pair and the recording's first frame through the appliance's own matcher, converter
// and fuser. The recording needs a rig. One line when they do not fit together.
dataset::Loaded<FusionResult> fuse_scene(const dataset::StereoScene& scene,
                                         const dataset::PmdRecording& recording,
                                         const dsp::MatchParams& params, int runs);

}  // namespace stof::host
