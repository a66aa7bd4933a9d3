#include "host/cli/evaluate/evaluate_stereo.h"

#include <algorithm>
#include <cstdio>
#include <set>

#include <nlohmann/json.hpp>

#include "host/cli/failure.h"
#include "host/evaluate/stereo/disparity_score.h"
#include "host/text/printed.h"

namespace stof::host {
namespace {

using nlohmann::ordered_json;

struct Row {
  std::string name;
  int width = 0;
  int height = 0;
  int ndisp = 0;
  double ms = 0;
  std::optional<std::uint64_t> energy = std::nullopt;
  DisparityScore score;
};

Row evaluate_scene(const dataset::StereoScene& scene, const EvaluateStereoOptions& options) {
  const MatchPlan plan = value_or_fail(match_plan(options.match, scene.ndisp));
  const MatchResult result = value_or_fail(match_scene(scene, plan));
  const dataset::Image<float> disparity = to_pixels(result.disparity.view());
  if (!options.out.empty()) {
    const std::filesystem::path folder = options.out / scene.name;
    make_folder(folder);
    value_or_fail(dataset::write_pfm(folder / "disp.pfm", disparity));
    if (plan.params.fill) {
      dataset::Image<std::uint8_t> marks = result.filled;
      std::ranges::transform(marks.pixels, marks.pixels.begin(),
                             [](std::uint8_t mark) { return mark == 0 ? 0 : 255; });
      value_or_fail(dataset::write_pgm8(folder / "filled.pgm", marks));
    }
  }
  return {.name = scene.name,
          .width = scene.left.width,
          .height = scene.left.height,
          .ndisp = scene.ndisp,
          .ms = result.median_ms,
          .energy = result.energy,
          .score = score_disparity(disparity, scene, plan.params.block_width)};
}

ordered_json percent(std::optional<double> share) { return json_number(share, kPercent); }

ordered_json to_json(double ms, const DisparityScore& score) {
  return {{"ms", ms},
          {"bp_percent",
           {{"all", percent(score.all)},
            {"nonocc", percent(score.visible)},
            {"core", percent(score.core)},
            {"valid", percent(score.of_valid)},
            {"signed_all", percent(score.signed_all)},
            {"signed_nonocc", percent(score.signed_visible)}}},
          {"density_percent", percent(score.density)}};
}

void print_json(const std::vector<Row>& rows, const Row& mean, const EvaluateOptions& options) {
  ordered_json report{{"matcher", describe(options.match)},
                      {"runs", options.match.runs},
                      {"threads", options.match.threads}};
  for (const Row& row : rows) {
    ordered_json scene{
        {"name", row.name}, {"width", row.width}, {"height", row.height}, {"ndisp", row.ndisp}};
    scene.update(to_json(row.ms, row.score));
    if (row.energy) {
      scene["energy"] = *row.energy;
    }
    report["scenes"].push_back(std::move(scene));
  }
  report["mean"] = to_json(mean.ms, mean.score);
  std::printf("%s\n", report.dump(2).c_str());
}

void print_row(const Row& row) {
  const DisparityScore& score = row.score;
  const std::string size =
      row.width == 0 ? "" : std::to_string(row.width) + "x" + std::to_string(row.height);
  const std::string ndisp = row.ndisp == 0 ? "" : std::to_string(row.ndisp);
  std::printf("%-16s %9s %5s %8.2f  %s %s %s %s  %s %s  %s\n", row.name.c_str(), size.c_str(),
              ndisp.c_str(), row.ms, percent_text(score.all, 6).c_str(),
              percent_text(score.visible, 6).c_str(), percent_text(score.core, 6).c_str(),
              percent_text(score.of_valid, 6).c_str(), percent_text(score.signed_all, 6).c_str(),
              percent_text(score.signed_visible, 6).c_str(),
              percent_text(score.density, 7).c_str());
}

void print_table(const std::vector<Row>& rows, const Row& mean, const EvaluateOptions& options) {
  std::printf("%s; ms: median of %d; bad pixels in percent: |d - truth| > 1 px or missing;\n",
              describe(options.match).c_str(), options.match.runs);
  std::printf("signed: d - truth > 1 px or missing\n\n");
  std::printf("%-16s %9s %5s %8s  %6s %6s %6s %6s  %6s %6s  %7s\n", "", "", "", "", "bad", "bad",
              "bad", "bad of", "signed", "signed", "");
  std::printf("%-16s %9s %5s %8s  %6s %6s %6s %6s  %6s %6s  %7s\n", "scene", "size", "ndisp", "ms",
              "all", "nonocc", "core", "valid", "all", "nonocc", "density");
  for (const Row& row : rows) {
    print_row(row);
  }
  if (rows.size() > 1) {
    print_row(mean);
  }
  for (const Row& row : rows) {
    if (row.energy) {
      std::printf(
          "%s: energy %llu\n", row.name.c_str(),
          static_cast<unsigned long long>(*row.energy));  // NOLINT(google-runtime-int): %llu
    }
  }
}

Row mean_row(const std::vector<Row>& rows) {
  Row mean{.name = "mean", .score = {}};
  std::vector<DisparityScore> scores;
  scores.reserve(rows.size());
  for (const Row& row : rows) {
    scores.push_back(row.score);
    mean.ms += row.ms / static_cast<double>(rows.size());
  }
  mean.score = mean_score(scores);
  return mean;
}

}  // namespace

void evaluate_stereo(const EvaluateStereoOptions& options) {
  value_or_fail(match_plan(options.match, 1));  // options first: they are wrong for every scene
  std::vector<dataset::StereoScene> scenes;
  std::set<std::string> names;
  for (const std::filesystem::path& dir : options.scenes) {
    scenes.push_back(value_or_fail(dataset::read_stereo_scene(dir)));
    if (!names.insert(scenes.back().name).second && !options.out.empty()) {
      throw Failure(Exit::kBadInput, dir.string() + ": a second scene named " + scenes.back().name +
                                         " for --out: give another folder name");
    }
  }
  std::vector<Row> rows;
  rows.reserve(scenes.size());
  for (const dataset::StereoScene& scene : scenes) {
    rows.push_back(evaluate_scene(scene, options));
  }
  if (options.json) {
    print_json(rows, mean_row(rows), options);
  } else {
    print_table(rows, mean_row(rows), options);
  }
}

}  // namespace stof::host
