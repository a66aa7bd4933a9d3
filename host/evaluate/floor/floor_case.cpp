#include "host/evaluate/floor/floor_case.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "dataset/files/file.h"
#include "host/evaluate/fusion/fusion_case.h"

namespace stof::host {

dataset::Loaded<FloorCase> run_floor_case(const std::filesystem::path& folder,
                                          std::span<const MatchRequest> matchers,
                                          const FusionOptions& options) {
  dataset::Loaded<RecordedPair> recorded = read_recorded_pair(folder, folder / "pmd");
  if (!recorded) {
    return std::unexpected(std::move(recorded.error()));
  }
  const dataset::StereoScene& pair = recorded->pair;
  if (!pair.floor || !pair.visible) {
    return dataset::refuse(folder.string() +
                           ": has no surfaces.pgm or no nonocc.pgm: give a scene above a floor "
                           "(stof_emu_pair DIR --scene floor)");
  }
  FloorCase done{.scene = pair.name,
                 .height_m = pair.floor->height_m,
                 .tilt_degrees = pair.floor->tilt_degrees,
                 .truth = std::move(recorded->depth),
                 .runs = {}};
  const FloorReference reference{.floor = *pair.floor,
                                 .visible = *pair.visible,
                                 .depth = done.truth,
                                 .lens = recorded->recording.calibration.stereo.left};
  for (const MatchRequest& matcher : matchers) {
    const std::expected<lab::MatchParams, dataset::Problem> params =
        fusion_params(matcher, pair.ndisp);
    if (!params) {
      return std::unexpected(params.error());
    }
    dataset::Loaded<FusionResult> result = fuse_scene(pair, recorded->recording, *params, options);
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
