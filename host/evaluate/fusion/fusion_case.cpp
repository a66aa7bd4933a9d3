#include "host/evaluate/fusion/fusion_case.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "dataset/files/file.h"
#include "host/evaluate/other_camera.h"
#include "host/text/printed.h"

namespace stof::host {
namespace {

std::string size_of(const dsp::Pinhole& lens) {
  return dataset::size_text(lens.width, lens.height);
}

// Forgets the truth of other pixels. false: there is none of the band.
bool keep_band(const DepthBand& band, dataset::Image<float>& truth) {
  bool any = false;
  for (float& depth : truth.pixels) {
    if (depth < band.nearest || depth > band.farthest) {
      depth = std::numeric_limits<float>::infinity();
    }
    any = any || std::isfinite(depth);
  }
  return any;
}

}  // namespace

std::string FusionCase::sensor() const { return size_of(lens); }

dataset::Loaded<RecordedPair> read_recorded_pair(const std::filesystem::path& scene,
                                                 const std::filesystem::path& prefix) {
  dataset::Loaded<dataset::StereoScene> pair = dataset::read_stereo_scene(scene);
  if (!pair) {
    return std::unexpected(std::move(pair.error()));
  }
  dataset::Loaded<dataset::PmdRecording> recording = dataset::read_pmd(prefix);
  if (!recording) {
    return std::unexpected(std::move(recording.error()));
  }
  if (!recording->has_rig) {
    return dataset::refuse(prefix.string() +
                           ".json: has no rig (stereo, R, T): give a recording of a scene");
  }
  if (!pair->truth) {
    return dataset::refuse(scene.string() + ": has no gt_left.pgm: give a scene with ground truth");
  }
  dsp::Calibration whole = recording->calibration;
  whole.stereo.left.width = pair->left.width;
  whole.stereo.left.height = pair->left.height;
  if (const std::string wrong = dsp::problem(whole); !wrong.empty()) {
    return dataset::refuse(dataset::file_of(prefix, ".json"), wrong + " with " + scene.string(),
                           "give the pair that it was recorded with, or correct the file");
  }
  dataset::Image<float> depth = depth_from_disparity(*pair->truth, recording->calibration.stereo);
  return RecordedPair{
      .pair = std::move(*pair), .recording = std::move(*recording), .depth = std::move(depth)};
}

dataset::Loaded<std::string> apply_calibration(const dsp::PmdSensor& found,
                                               const std::filesystem::path& prefix,
                                               dataset::PmdRecording& recording) {
  dsp::PmdSensor& camera = recording.calibration.pmd;
  if (const std::string why = other_camera(found, camera); !why.empty()) {
    return dataset::refuse(dataset::file_of(prefix, ".json"), why,
                           "give the calibration of this camera");
  }
  const std::string known = size_of(found.lens);
  const std::string own = size_of(camera.lens);
  dsp::PmdSensor sensor = found;
  sensor.lens = camera.lens;
  sensor.second = std::nullopt;  // the recording has one frequency
  if (found.fixed_pattern.empty() || known != own) {
    sensor.fixed_pattern = camera.fixed_pattern;
  }
  camera = sensor;
  return known == own ? std::string()
                      : "a calibration of " + known + " pixels for recordings of " + own +
                            ": phase, lights and noise are carried over; the lens and the fixed "
                            "pattern stay those of the recordings";
}

dataset::Loaded<FusionCase> run_fusion_case(const std::filesystem::path& scene,
                                            const std::filesystem::path& prefix,
                                            const MatchRequest& match,
                                            const FusionOptions& options) {
  dataset::Loaded<RecordedPair> recorded = read_recorded_pair(scene, prefix);
  if (!recorded) {
    return std::unexpected(std::move(recorded.error()));
  }
  if (!keep_band(options.truth, recorded->depth)) {
    return dataset::refuse(scene.string(),
                           printed("no true depth lies between %g and %g m",
                                   double{options.truth.nearest}, double{options.truth.farthest}),
                           "give another range");
  }
  dataset::Loaded<std::string> note;
  if (options.camera) {
    note = apply_calibration(*options.camera, prefix, recorded->recording);
    if (!note) {
      return std::unexpected(std::move(note.error()));
    }
  }
  dataset::StereoScene& pair = recorded->pair;
  const dsp::Calibration& calibration = recorded->recording.calibration;
  const std::expected<lab::MatchParams, dataset::Problem> params = fusion_params(match, pair.ndisp);
  if (!params) {
    return std::unexpected(params.error());
  }
  dataset::Loaded<FusionResult> result = fuse_scene(pair, recorded->recording, *params, options);
  if (!result) {
    return std::unexpected(std::move(result.error()));
  }
  FusionCase done{.scene = pair.name,
                  .recording = prefix.filename().string(),
                  .lens = calibration.pmd.lens,
                  .rig = calibration.stereo,
                  .left = std::move(pair.left),
                  .truth = std::move(recorded->depth),
                  .note = std::move(*note),
                  .result = std::move(*result),
                  .scores = {}};
  done.scores = score_fusion(done.result, done.truth);
  return done;
}

std::vector<std::string> sensors_of(std::span<const FusionCase> cases) {
  std::vector<std::string> sensors;
  for (const FusionCase& fused : cases) {
    if (std::ranges::find(sensors, fused.sensor()) == sensors.end()) {
      sensors.push_back(fused.sensor());
    }
  }
  return sensors;
}

FusionScores mean_of_sensor(std::span<const FusionCase> cases, const std::string& sensor) {
  std::vector<FusionScores> scores;
  for (const FusionCase& fused : cases) {
    if (sensor.empty() || fused.sensor() == sensor) {
      scores.push_back(fused.scores);
    }
  }
  return mean_scores(scores);
}

}  // namespace stof::host
