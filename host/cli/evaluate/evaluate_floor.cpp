#include "host/cli/evaluate/evaluate_floor.h"

#include <algorithm>
#include <cstdio>
#include <set>

#include <nlohmann/json.hpp>

#include "host/cli/failure.h"
#include "host/cli/help_text.h"
#include "host/evaluate/floor/floor_case.h"
#include "host/evaluate/fusion/depth_score.h"
#include "host/picture/error_picture.h"
#include "host/text/printed.h"

namespace stof::host {
namespace {

using dataset::Surface;
using nlohmann::ordered_json;

// One line of the table.
struct FloorRow {
  std::string scene;
  std::string matcher;
  const char* source;
  FloorScore score;
  std::optional<double> height_m = std::nullopt;  // of the camera; a mean has no pose
  std::optional<double> tilt_degrees = std::nullopt;
};

// Every preset where the command line names nothing.
std::vector<MatchRequest> matchers(const MatchRequest& asked) {
  std::vector<MatchRequest> out;
  if (asked.preset.empty() && asked.settings.empty()) {
    for (const char* const preset : {"fast", "quality", "chapter"}) {
      out.push_back(asked);
      out.back().preset = preset;
    }
  } else {
    out.push_back(asked);
  }
  for (const MatchRequest& matcher : out) {
    value_or_fail(fusion_params(matcher, 1));  // options first: they are wrong for every scene
  }
  return out;
}

void write_maps(const FloorCase& floor, const std::filesystem::path& folder) {
  for (const FloorRun& run : floor.runs) {
    std::string matcher = run.matcher;
    std::ranges::replace(matcher, ' ', '_');
    for (const FloorDepth& made : run.depths) {
      const std::filesystem::path to = folder / floor.scene / matcher / made.source;
      make_folder(to);
      value_or_fail(dataset::write_pfm(to / "depth.pfm", made.depth));
      const dataset::Image<float> error = relative_error(made.depth, floor.truth);
      value_or_fail(write_png(
          to / "error.png", depth_error_picture(error, kLargestRelativeError),
          {{"Description", "blue: too near, red: too far, 5 percent or more; grey: none"}}));
    }
  }
}

ordered_json to_json(const SurfaceScore& score) {
  return {{"pixels", score.pixels},
          {"off_percent", json_number(score.off, kPercent)},
          {"missing_percent", json_number(score.missing, kPercent)},
          {"median_error_mm", json_number(score.median_error_m, kMm)},
          {"p95_error_mm", json_number(score.p95_error_m, kMm)}};
}

ordered_json to_json(const FloorRow& row) {
  const FloorScore& score = row.score;
  ordered_json out{{"scene", row.scene},
                   {"camera_height_m", json_number(row.height_m)},
                   {"camera_tilt_degrees", json_number(row.tilt_degrees)},
                   {"matcher", row.matcher},
                   {"source", row.source}};
  out["floor"] = to_json(score.of(Surface::kFloor));
  out["floor"]["missing_anywhere_percent"] = json_number(score.missing_anywhere, kPercent);
  out["floor"]["obstacle_percent"] = json_number(score.obstacle, kPercent);
  out["box"] = to_json(score.of(Surface::kBox));
  out["wall"] = to_json(score.of(Surface::kWall));
  out["lower_floor"] = to_json(score.of(Surface::kLowerFloor));
  out["lower_floor"]["no_drop_percent"] = json_number(score.no_drop, kPercent);
  out["glass"] = to_json(score.of(Surface::kGlass));
  out["glass"]["conflict_percent"] = json_number(score.conflict, kPercent);
  return out;
}

void print_json(const std::vector<FloorRow>& rows, const std::vector<FloorRow>& means) {
  ordered_json report{{"rows", ordered_json::array()}, {"mean", ordered_json::array()}};
  for (const FloorRow& row : rows) {
    report["rows"].push_back(to_json(row));
  }
  for (const FloorRow& row : means) {
    report["mean"].push_back(to_json(row));
  }
  std::printf("%s\n", report.dump(2).c_str());
}

void print_head() {
  std::printf(
      "Percent of the pixels that both cameras see, floor up to 4 m. off: by more than 5 percent\n"
      "of depth; any: missing, also where one camera sees it; >3cm: an obstacle above the floor;\n"
      "flat: lower floor that seems less than half as low as it is; conf: the sensors contradict\n"
      "each other. Of glass, missing is right and off is wrong.\n\n");
  std::printf("%-41s%-48s%-14s%-14s%-21s%s\n", "", "   floor", "   box", "   wall",
              "   lower floor", "   glass");
  std::printf("%-16s %-16s %-7s%7s%7s%7s%7s%10s%10s", "scene", "matcher", "source", "off", "miss",
              "any", ">3cm", "median mm", "p95 mm");
  for (const char* const head :
       {"off", "miss", "off", "miss", "off", "miss", "flat", "off", "miss", "conf"}) {
    std::printf("%7s", head);
  }
  std::printf("\n");
}

void print_row(const FloorRow& row) {
  const auto share = [](std::optional<double> value) { return percent_text(value, 7); };
  const auto mm = [](std::optional<double> metres) {
    return cell(metres ? std::optional(*metres * kMm) : std::nullopt, 10, 1);
  };
  const FloorScore& score = row.score;
  const SurfaceScore& floor = score.of(Surface::kFloor);
  std::string line =
      printed("%-16s %-16s %-7s", row.scene.c_str(), row.matcher.c_str(), row.source);
  line += share(floor.off) + share(floor.missing) + share(score.missing_anywhere) +
          share(score.obstacle) + mm(floor.median_error_m) + mm(floor.p95_error_m);
  for (const Surface surface :
       {Surface::kBox, Surface::kWall, Surface::kLowerFloor, Surface::kGlass}) {
    line += share(score.of(surface).off) + share(score.of(surface).missing);
    line += surface == Surface::kLowerFloor ? share(score.no_drop) : "";
  }
  std::printf("%s%s\n", line.c_str(), share(score.conflict).c_str());
}

// One for each matcher and source, in the order of the rows.
std::vector<FloorRow> mean_rows(const std::vector<FloorRow>& rows) {
  std::vector<FloorRow> means;
  for (const FloorRow& first : rows) {
    const auto same = [&first](const FloorRow& row) {
      return row.matcher == first.matcher && row.source == std::string_view(first.source);
    };
    if (std::ranges::any_of(means, same)) {
      continue;
    }
    std::vector<FloorScore> scores;
    for (const FloorRow& row : rows) {
      if (same(row)) {
        scores.push_back(row.score);
      }
    }
    means.push_back({.scene = "mean",
                     .matcher = first.matcher,
                     .source = first.source,
                     .score = mean_score(std::span<const FloorScore>(scores))});
  }
  return means;
}

}  // namespace

void add_evaluate_floor(CLI::App& evaluate, EvaluateFloorOptions& options) {
  CLI::App& command = *evaluate.add_subcommand(
      "floor", "Scenes above a floor: what a robot would take for an obstacle, a drop, a way");
  show_example(command, "stof evaluate floor floors/60,15", kFilesEnds);
  command
      .add_option("DIR", options.folders,
                  "Folders of scenes above a floor, as stof_emu_pair DIR --scene floor writes "
                  "them; without a PMD recording (pmd.json) stereo alone is scored. Without "
                  "--preset and settings each is matched with every preset")
      ->required();
  add_evaluate_flags(command, options, Judged::kDepth);
  add_out_flag(command, options);
  command.callback([&options] { evaluate_floor(options); });
}

void evaluate_floor(const EvaluateFloorOptions& options) {
  const std::vector<MatchRequest> asked = matchers(options.match);
  const FusionOptions fusion{.runs = 1, .threads = options.match.threads};
  std::vector<FloorRow> rows;
  std::set<std::string> names;
  for (const std::filesystem::path& folder : options.folders) {
    const FloorCase floor = value_or_fail(run_floor_case(folder, asked, fusion));
    if (!options.out.empty() && !names.insert(floor.scene).second) {
      throw Failure(Exit::kBadInput, folder.string() + ": a second scene named " + floor.scene +
                                         " for --out: give another folder name");
    }
    for (const FloorRun& run : floor.runs) {
      for (const FloorDepth& made : run.depths) {
        rows.push_back({.scene = floor.scene,
                        .matcher = run.matcher,
                        .source = made.source,
                        .score = made.score,
                        .height_m = floor.height_m,
                        .tilt_degrees = floor.tilt_degrees});
      }
    }
    if (!options.out.empty()) {
      write_maps(floor, options.out);
    }
  }
  const std::vector<FloorRow> means = mean_rows(rows);
  if (options.json) {
    print_json(rows, means);
    return;
  }
  print_head();
  for (const FloorRow& row : rows) {
    print_row(row);
  }
  for (const FloorRow& row : means) {
    if (options.folders.size() > 1) {
      print_row(row);
    }
  }
}

}  // namespace stof::host
