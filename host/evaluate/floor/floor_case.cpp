#include "host/evaluate/floor/floor_case.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "dataset/files/file.h"
#include "host/evaluate/fusion/depth_score.h"
#include "host/evaluate/fusion/fusion_case.h"
#include "host/text/printed.h"

namespace stof::host {

namespace {

// With the PMD recording `pmd` of the folder, else with a PMD camera of 0x0 pixels.
dataset::Loaded<RecordedPair> read_pair(const std::filesystem::path& folder) {
  const std::filesystem::path prefix = folder / "pmd";
  if (dataset::is_there(folder / "pmd.json")) {
    return read_recorded_pair(folder, prefix);
  }
  dataset::Loaded<dataset::StereoScene> pair = dataset::read_stereo_scene(folder);
  if (!pair) {
    return std::unexpected(std::move(pair.error()));
  }
  if (!pair->truth || !pair->rig) {
    return dataset::refuse(folder.string() +
                           ": has no gt_left.pgm, or neither pmd.json nor f_px and baseline_m in "
                           "meta.txt: give a scene with ground truth and its rig");
  }
  RecordedPair alone{.pair = std::move(*pair), .recording = {}, .depth = {}};
  alone.recording.calibration.stereo = *alone.pair.rig;
  alone.depth = depth_from_disparity(*alone.pair.truth, *alone.pair.rig);
  return alone;
}

// What is not of one floor, pose and rig would be judged wrongly without a word.
std::expected<void, dataset::Problem> check_pose(const std::filesystem::path& folder,
                                                 const FloorReference& reference) {
  const std::optional<double> above = floor_above_pose(reference);
  if (above && !(std::abs(*above) <= kObstacleM)) {
    return dataset::refuse(
        (folder / "meta.txt").string() +
        printed(": by its depths the floor is %.2f m %s where camera_height_m and "
                "camera_tilt_degrees put it: correct them, or the rig",
                std::abs(*above), *above > 0 ? "above" : "below"));
  }
  return {};
}

}  // namespace

dataset::Loaded<FloorCase> run_floor_case(const std::filesystem::path& folder,
                                          std::span<const MatchRequest> matchers,
                                          const FusionOptions& options) {
  dataset::Loaded<RecordedPair> recorded = read_pair(folder);
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
  if (auto fits = check_pose(folder, reference); !fits) {
    return std::unexpected(std::move(fits.error()));
  }
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
    FloorRun run{.matcher = describe(matcher), .depths = {}};
    const auto add = [&](const char* source, dataset::Image<float>& depth,
                         std::span<const dsp::Source> sources) {
      const FloorScore score = score_floor(depth, sources, reference);
      run.depths.push_back({.source = source, .depth = std::move(depth), .score = score});
    };
    add("stereo", result->stereo.depth, {});
    if (!result->fused.depth.pixels.empty()) {
      add("fused", result->fused.depth, result->source.pixels);
    }
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
