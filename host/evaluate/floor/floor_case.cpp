#include "host/evaluate/floor/floor_case.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "dataset/files/file.h"

namespace stof::host {
namespace {

const char* what_is_missing(const dataset::StereoScene& scene) {
  if (!scene.floor) {
    return "has no surfaces.pgm: give a scene above a floor (stof_emu_pair DIR --scene floor)";
  }
  if (!scene.truth || !scene.visible) {
    return "has no gt_left.pgm or no nonocc.pgm: give a scene with ground truth";
  }
  return nullptr;
}

}  // namespace

dataset::Loaded<FloorCase> run_floor_case(const std::filesystem::path& folder,
                                          std::span<const MatchOptions> matchers,
                                          const FusionOptions& options) {
  const dataset::Loaded<dataset::StereoScene> pair = dataset::read_stereo_scene(folder);
  if (!pair) {
    return std::unexpected(pair.error());
  }
  if (const char* const what = what_is_missing(*pair)) {
    return dataset::refuse(folder.string() + ": " + what);
  }
  const dataset::Loaded<dataset::PmdRecording> recording = dataset::read_pmd(folder / "pmd");
  if (!recording) {
    return std::unexpected(recording.error());
  }
  if (!recording->has_rig) {
    return dataset::refuse((folder / "pmd.json").string() +
                           ": has no rig (stereo, R, T): give a recording of a scene");
  }
  const dsp::StereoRig& rig = recording->calibration.stereo;
  FloorCase done{.scene = pair->name,
                 .height_m = pair->floor->height_m,
                 .tilt_degrees = pair->floor->tilt_degrees,
                 .truth = depth_from_disparity(*pair->truth, rig),
                 .runs = {}};
  const FloorReference reference{
      .floor = *pair->floor, .visible = *pair->visible, .depth = done.truth, .lens = rig.left};
  for (const MatchOptions& matcher : matchers) {
    const std::expected<lab::MatchParams, dataset::Problem> params =
        fusion_params(matcher, pair->ndisp);
    if (!params) {
      return std::unexpected(params.error());
    }
    dataset::Loaded<FusionResult> result = fuse_scene(*pair, *recording, *params, options);
    if (!result) {
      return std::unexpected(std::move(result.error()));
    }
    FloorRun run{.matcher = describe(matcher),
                 .stereo = std::move(result->stereo.depth),
                 .fused = std::move(result->fused.depth),
                 .stereo_score = {},
                 .fused_score = {}};
    run.stereo_score = score_floor(run.stereo, {}, reference);
    run.fused_score = score_floor(run.fused, result->source.pixels, reference);
    done.runs.push_back(std::move(run));
  }
  return done;
}

dataset::Image<float> relative_error(const dataset::Image<float>& depth,
                                     const dataset::Image<float>& truth) {
  dataset::Image<float> error(depth.width, depth.height);
  std::ranges::transform(depth.pixels, truth.pixels, error.pixels.begin(), [](float z, float t) {
    return std::isfinite(z) && std::isfinite(t) ? (z - t) / t
                                                : std::numeric_limits<float>::infinity();
  });
  return error;
}

}  // namespace stof::host
