#include "host/cli/evaluate/evaluate_sequence.h"

#include <cmath>
#include <cstdio>

#include <nlohmann/json.hpp>

#include "dsp/depth/max_range.h"
#include "host/cli/failure.h"
#include "host/cli/help_text.h"
#include "host/evaluate/fusion/fusion.h"
#include "host/evaluate/sequence/sequence.h"
#include "host/text/printed.h"

namespace stof::host {
namespace {

using nlohmann::ordered_json;

// With every matcher, without the temporal filter and with it. `fast` and `quality` where the
// command line names nothing.
std::vector<SequenceRun> runs_of(const EvaluateSequenceOptions& options) {
  std::vector<MatchRequest> matchers(1, options.match);
  if (options.match.preset.empty() && options.match.settings.empty()) {
    matchers.assign(2, options.match);
    matchers[0].preset = "fast";
    matchers[1].preset = "quality";
  }
  std::vector<SequenceRun> runs;
  for (const MatchRequest& matcher : matchers) {
    value_or_fail(fusion_params(matcher, 1));  // options first: they are wrong for every scene
    for (const bool temporal : {false, true}) {
      runs.push_back({.matcher = matcher,
                      .options = {.max_range = static_cast<dsp::QuarterMm>(
                                      std::lround(options.max_range_m * dsp::kQuarterMmPerMetre)),
                                  .temporal = temporal,
                                  .threads = options.match.threads}});
    }
  }
  return runs;
}

ordered_json to_json(const std::string& scene, const SequenceRun& run,
                     const SequenceResult& result) {
  const SequenceScore& score = result.score;
  ordered_json stays = ordered_json::array();
  for (const std::optional<double>& share : score.stays) {
    stays.push_back(json_number(share, kPercent));
  }
  return {{"scene", scene},
          {"matcher", describe(run.matcher)},
          {"temporal", run.options.temporal},
          {"flicker_percent", json_number(score.flicker, kPercent)},
          {"jumps_percent", json_number(score.jumps, kPercent)},
          {"noise_mm", json_number(score.noise_m, kMm)},
          {"e5_percent", kPercent * score.depth.e5},
          {"coverage_percent", kPercent * score.depth.coverage},
          {"inside_percent", json_number(score.depth.hit_rate, kPercent)},
          {"nearer_percent", json_number(score.depth.collisions, kPercent)},
          {"median_error_mm", json_number(score.depth.median_error_m, kMm)},
          {"moving_e5_percent", json_number(score.moving_e5, kPercent)},
          {"stays_percent", stays},
          {"fuse_ms", result.fuse_ms}};
}

void print_sequence_head() {
  std::printf(
      "Percent of pixels, mean of the frames. Where nothing moves in six frames: flick: with a "
      "depth\n"
      "in some and none in others; jump: by more than 0.5 m; noise: median deviation. >1m: nearer\n"
      "than told by over 1 m. move: E5 where something has moved within six frames. stays: of the\n"
      "pixels that a surface has left, those whose depth is still nearer to it than to what is\n"
      "behind, in the frame when it left, one later, and two. Beside the edge of what is still in\n"
      "the picture a single frame shows such depth, too: compare with and without time.\n\n");
  std::printf("%-20s %-15s %-5s%7s%7s%9s%7s%7s%7s%7s%7s%22s%9s\n", "scene", "matcher", "time",
              "flick", "jump", "noise mm", "E5", "cover", "inside", ">1m", "move",
              "stays      0  1  2", "fuse ms");
}

void print_row(const std::string& scene, const SequenceRun& run, const SequenceResult& result) {
  const auto share = [](std::optional<double> value) { return percent_text(value, 7); };
  const SequenceScore& score = result.score;
  std::string line = printed("%-20s %-15s %-5s", scene.c_str(), describe(run.matcher).c_str(),
                             run.options.temporal ? "yes" : "no");
  line += share(score.flicker) + share(score.jumps);
  line += cell(score.noise_m ? std::optional(*score.noise_m * kMm) : std::nullopt, 9, 1);
  line += share(score.depth.e5) + share(score.depth.coverage) + share(score.depth.hit_rate) +
          share(score.depth.collisions) + share(score.moving_e5) + " ";
  for (const std::optional<double>& stays : score.stays) {
    line += share(stays);
  }
  std::printf("%s%9.2f\n", line.c_str(), result.fuse_ms);
}

}  // namespace

void add_evaluate_sequence(CLI::App& evaluate, EvaluateSequenceOptions& options) {
  CLI::App& command = *evaluate.add_subcommand(
      "sequence", "Frames that follow each other: flicker, jumps, noise, what stays behind");
  show_example(command, "stof evaluate sequence sequences/hall --preset quality", kFilesEnds);
  command
      .add_option("DIR", options.folders,
                  "Folders that stof_emu_pair DIR --sequence N wrote; without --preset and "
                  "settings each is matched with fast and quality")
      ->required();
  command.add_option("--warm-up", options.warm_up, "Frames that come before those that are judged")
      ->check(CLI::Range(0, 100000))
      ->capture_default_str();
  command.add_option("--max-range", options.max_range_m, "Metres beyond which nothing is measured")
      ->check(CLI::Range(dsp::kLeastMaxRangeMm / kMm, dsp::kMostMaxRangeMm / kMm))
      ->capture_default_str();
  add_evaluate_flags(command, options, Judged::kDepth);
  command.callback([&options] { evaluate_sequence(options); });
}

void evaluate_sequence(const EvaluateSequenceOptions& options) {
  const std::vector<SequenceRun> runs = runs_of(options);
  ordered_json rows = ordered_json::array();
  if (!options.json) {
    print_sequence_head();
  }
  for (const std::filesystem::path& folder : options.folders) {
    const std::vector<SequenceResult> results =
        value_or_fail(run_sequence(folder, runs, options.warm_up));
    const std::string scene = (folder / "").parent_path().filename().string();
    for (std::size_t i = 0; i < runs.size(); ++i) {
      if (options.json) {
        rows.push_back(to_json(scene, runs[i], results[i]));
      } else {
        print_row(scene, runs[i], results[i]);
      }
    }
  }
  if (options.json) {
    std::printf("%s\n", ordered_json{{"rows", rows}}.dump(2).c_str());
  }
}

}  // namespace stof::host
