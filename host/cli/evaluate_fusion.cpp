#include <cstdio>

#include <nlohmann/json.hpp>

#include "host/cli/evaluate.h"
#include "host/cli/exit.h"
#include "host/evaluate/fusion.h"

namespace stof::host {
namespace {

using nlohmann::ordered_json;

constexpr double kMillimetres = 1000;

struct Scores {
  DepthScore pmd;
  DepthScore stereo;
  DepthScore fused;
};

ordered_json number(std::optional<double> value, double unit = 1) {
  return value ? ordered_json(*value * unit) : ordered_json(nullptr);
}

ordered_json to_json(const DepthScore& score) {
  return {{"e5", score.e5},
          {"coverage", score.coverage},
          {"median_error_mm", number(score.median_error_m, kMillimetres)},
          {"median_error_relative", number(score.median_relative)},
          {"hit_rate", number(score.hit_rate)},
          {"median_width_mm", number(score.median_width_m, kMillimetres)}};
}

void print_row(const char* name, const DepthScore& score) {
  std::printf(
      "%-8s %7.4f  %7s %%  %8.1f mm %s %%  %s %%  %8.1f mm\n", name, score.e5,
      percent_text(score.coverage, 7).c_str(), score.median_error_m.value_or(0) * kMillimetres,
      percent_text(score.median_relative, 6).c_str(), percent_text(score.hit_rate, 7).c_str(),
      score.median_width_m.value_or(0) * kMillimetres);
}

void print_table(const Scores& scores) {
  std::printf("%-8s %7s  %9s  %20s  %9s  %11s\n", "", "E5", "coverage", "median error", "hit rate",
              "median width");
  print_row("pmd", scores.pmd);
  print_row("stereo", scores.stereo);
  print_row("fused", scores.fused);
}

void write_maps(const DepthPlanes& planes, const std::filesystem::path& folder) {
  make_folder(folder);
  value_or_fail(dataset::write_pfm(folder / "depth.pfm", planes.depth));
  value_or_fail(dataset::write_pfm(folder / "lo.pfm", planes.low));
  value_or_fail(dataset::write_pfm(folder / "hi.pfm", planes.high));
}

// What the scores were made from.
struct Source {
  std::string scene;
  std::string recording;
  dsp::Pinhole lens;
  MatchOptions match;
};

void print_json(const Source& source, const FusionResult& result, const Scores& scores) {
  const ordered_json report{
      {"scene", source.scene},
      {"pmd_width", source.lens.width},
      {"pmd_height", source.lens.height},
      {"matcher", describe(source.match)},
      {"runs", source.match.runs},
      {"truth_pixels", scores.fused.truth_pixels},
      {"ms",
       {{"match", result.match_ms}, {"convert", result.convert_ms}, {"fuse", result.fuse_ms}}},
      {"pmd", to_json(scores.pmd)},
      {"stereo", to_json(scores.stereo)},
      {"fused", to_json(scores.fused)}};
  std::printf("%s\n", report.dump(2).c_str());
}

void print_text(const Source& source, const FusionResult& result, const Scores& scores) {
  std::printf("%s with %s (%dx%d); %s; ms: match %.2f, convert %.2f, fuse %.2f\n",
              source.scene.c_str(), source.recording.c_str(), source.lens.width, source.lens.height,
              describe(source.match).c_str(), result.match_ms, result.convert_ms, result.fuse_ms);
  std::printf(
      "E5: share of pixels with truth that are missing or off by more than 5 %% of depth\n\n");
  print_table(scores);
}

// Holes are never filled silently, and what was not checked is no measurement.
void refuse_what_cannot_be_fused(const MatchPlan& plan) {
  if (plan.annealing) {
    throw Failure(Exit::kBadInput,
                  "--method sa: an offline reference, not for fusion: use another");
  }
  if (plan.params.fill) {
    throw Failure(Exit::kBadInput,
                  "--fill: made-up disparities do not enter the fusion: leave it out");
  }
  if (!plan.params.left_right_tolerance) {
    throw Failure(Exit::kBadInput, "--lr=off: only checked matches enter the fusion: leave it out");
  }
}

}  // namespace

void evaluate_fusion(const EvaluateFusionOptions& options) {
  MatchOptions match = options.match;
  if (match.preset.empty()) {
    // Only checked matches may enter the fusion.
    match.settings.insert(match.settings.begin(), {"lr", "1"});
  }
  refuse_what_cannot_be_fused(value_or_fail(match_plan(match, 1)));
  const dataset::StereoScene scene = value_or_fail(dataset::read_stereo_scene(options.scene));
  const dataset::PmdRecording recording = value_or_fail(dataset::read_pmd(options.prefix));
  if (!recording.has_rig) {
    throw Failure(
        Exit::kBadInput,
        options.prefix.string() + ".json: has no rig (stereo, R, T): give a recording of a scene");
  }
  if (!scene.truth) {
    throw Failure(Exit::kBadInput,
                  options.scene.string() + ": has no gt_left.pgm: give a scene with ground truth");
  }
  const dsp::MatchParams params = value_or_fail(match_plan(match, scene.ndisp)).params;
  const FusionResult result = value_or_fail(fuse_scene(scene, recording, params, match.runs));
  const dataset::Image<float> truth =
      depth_from_disparity(*scene.truth, recording.calibration.stereo);
  const Scores scores{.pmd = score_depth(result.pmd, truth),
                      .stereo = score_depth(result.stereo, truth),
                      .fused = score_depth(result.fused, truth)};
  if (!options.out.empty()) {
    write_maps(result.fused, options.out);
  }
  const Source source{.scene = scene.name,
                      .recording = options.prefix.filename().string(),
                      .lens = recording.calibration.pmd.lens,
                      .match = match};
  if (options.json) {
    print_json(source, result, scores);
  } else {
    print_text(source, result, scores);
  }
}

}  // namespace stof::host
