#pragma once

#include <array>
#include <expected>
#include <limits>
#include <optional>

#include "dataset/dataset.h"
#include "dsp/depth/depth_maker.h"
#include "dsp/fusion/depth_map.h"
#include "host/evaluate/fusion/depth_score.h"
#include "host/evaluate/stereo/match.h"

namespace stof::host {

// Metres, both ends included.
struct DepthBand {
  float nearest = 0;
  float farthest = std::numeric_limits<float>::infinity();
};

// How a recorded scene is fused, and which of its pixels are judged.
struct FusionOptions {
  dsp::QuarterMm max_range = dsp::FusionParams{}.max_range;
  bool guided = false;            // PMD intervals narrow the search
  bool chapter_geometry = false;  // adds FusionResult::chapter
  // What a calibration found of the PMD camera, in place of what the recording's json says. The
  // lens stays the recording's, and so does the fixed pattern where the calibrated picture has
  // another size. Of run_fusion_case().
  std::optional<dsp::PmdSensor> camera = std::nullopt;
  DepthBand truth = {};  // pixels of another true depth are not judged. Of run_fusion_case()
  int runs = 1;          // of which the median time is taken
  int threads = 1;       // that match and fuse; no result depends on it
};

// The parameters a scene of `disparities` candidates is matched with. A preset means what the
// appliance makes of it (for_depth()); a method named alone has whole disparities and the
// left-right check. The request's settings come on top. Refused in one line: what match_plan()
// refuses, annealing, filled and unchecked disparities.
std::expected<lab::MatchParams, dataset::Problem> fusion_params(const MatchRequest& request,
                                                                int disparities);

// The same sensors with less effort, to see what the effort gains (chapter_geometry.h).
struct ChapterPlanes {
  DepthPlanes pmd;          // PMD map scaled to the left picture
  DepthPlanes fused;        // the interval rule on it
  DepthPlanes reprojected;  // the interval rule alone, on readings where they belong
};

// What most of the PMD pixels without a distance lack it for.
struct PmdLoss {
  const char* cause = "";
  double share = 0;  // of all PMD pixels
};

// Depth of one scene from each sensor alone and from both, in the left view.
struct FusionResult {
  DepthPlanes pmd;     // nothing of the stereo pair in it
  DepthPlanes stereo;  // the left-right-checked, unfilled map that enters the fusion; nothing of
                       // the PMD in it, also where that guides the search afterwards
  DepthPlanes fused;
  dataset::Image<dsp::Source> source;  // of fused
  dataset::Image<dsp::Cause> cause;
  std::optional<PmdLoss> pmd_loss;  // none where every PMD pixel has a distance
  std::optional<ChapterPlanes> chapter;
  double match_ms = 0;  // medians
  double convert_ms = 0;
  double fuse_ms = 0;
};

// The scene's pair and the recording's first frame through the appliance's own DepthMaker. The
// recording needs a rig; where its PMD camera has 0x0 pixels the result is `stereo` alone. One line
// when they do not fit together.
dataset::Loaded<FusionResult> fuse_scene(const dataset::StereoScene& scene,
                                         const dataset::PmdRecording& recording,
                                         const lab::MatchParams& match,
                                         const FusionOptions& options);

// How many pixels have each source or cause.
std::array<std::size_t, dsp::kSources> count_sources(const dataset::Image<dsp::Source>& source);
std::array<std::size_t, dsp::kCauses> count_causes(const dataset::Image<dsp::Cause>& cause);

// The fused pixels of one source that have truth and a depth.
struct SourceScore {
  double share = 0;                  // of the pixels with truth
  std::optional<double> off;         // by more than kLargestRelativeError
  std::optional<double> hit_rate;    // as in DepthScore
  std::optional<double> collisions;  // as in DepthScore
};
using SourceScores = std::array<SourceScore, dsp::kSources>;

// The DepthScore of each part of a result.
struct FusionScores {
  DepthScore pmd;
  DepthScore stereo;
  DepthScore fused;
  SourceScores by_source;  // of fused; a mean of several results weighs each by its share
  std::optional<DepthScore> chapter_pmd;
  std::optional<DepthScore> chapter_fused;
  std::optional<DepthScore> reprojected;

  // E5 below that of each sensor alone.
  bool fused_is_best() const { return fused.e5 < pmd.e5 && fused.e5 < stereo.e5; }
};
FusionScores score_fusion(const FusionResult& result, const dataset::Image<float>& truth);
// As mean_score().
FusionScores mean_scores(std::span<const FusionScores> scores);

}  // namespace stof::host
