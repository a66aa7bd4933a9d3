#include "host/cli/evaluate/fusion_print.h"

#include <algorithm>
#include <cstdio>

#include <nlohmann/json.hpp>

#include "host/cli/evaluate/evaluate.h"
#include "host/client/value_names.h"
#include "host/report/fusion/fusion_page.h"
#include "host/text/printed.h"

namespace stof::host {
namespace {

using nlohmann::ordered_json;

constexpr const char* kE5 =
    "E5: share of pixels with truth that are missing or off by more than 5 % of depth\n";

ordered_json to_json(const DepthScore& score) {
  ordered_json by_width = ordered_json::array();
  for (const std::optional<double>& rate : score.hit_rate_by_width) {
    by_width.push_back(json_number(rate));
  }
  return {{"e5", score.e5},
          {"coverage", score.coverage},
          {"median_error_mm", json_number(score.median_error_m, kMm)},
          {"median_error_relative", json_number(score.median_relative)},
          {"hit_rate", json_number(score.hit_rate)},
          {"collisions", json_number(score.collisions)},
          {"hit_rate_by_width", std::move(by_width)},
          {"median_width_mm", json_number(score.median_width_m, kMm)},
          {"median_width_relative", json_number(score.median_width_relative)}};
}

void add_scores(const FusionScores& scores, ordered_json& report) {
  report["pmd"] = to_json(scores.pmd);
  report["stereo"] = to_json(scores.stereo);
  report["fused"] = to_json(scores.fused);
  for (std::size_t k = 0; k < scores.by_source.size(); ++k) {
    const SourceScore& score = scores.by_source[k];
    report["by_source"][client::kSourceNames[k]] = {{"share", score.share},
                                                    {"off", json_number(score.off)},
                                                    {"hit_rate", json_number(score.hit_rate)},
                                                    {"collisions", json_number(score.collisions)}};
  }
  if (scores.chapter_fused) {
    report["chapter_pmd"] = to_json(*scores.chapter_pmd);
    report["chapter_fused"] = to_json(*scores.chapter_fused);
    report["interval_rule"] = to_json(*scores.reprojected);
  }
}

template <std::size_t kCount>
ordered_json counts(const std::array<const char*, kCount>& names,
                    const std::array<std::size_t, kCount>& numbers) {
  ordered_json report;
  for (std::size_t i = 0; i < kCount; ++i) {
    report[names[i]] = numbers[i];
  }
  return report;
}

ordered_json to_json(const FusionCase& fused, const MatchRequest& match) {
  const FusionResult& result = fused.result;
  ordered_json report{
      {"scene", fused.scene},
      {"recording", fused.recording},
      {"pmd_width", fused.lens.width},
      {"pmd_height", fused.lens.height},
      {"matcher", describe(match)},
      {"runs", match.runs},
      {"threads", match.threads},
      {"truth_pixels", fused.scores.fused.truth_pixels},
      {"ms",
       {{"match", result.match_ms}, {"convert", result.convert_ms}, {"fuse", result.fuse_ms}}}};
  add_scores(fused.scores, report);
  report["fused_is_best"] = fused.scores.fused_is_best();
  report["sources"] = counts(client::kSourceNames, count_sources(result.source));
  report["causes"] = counts(client::kCauseNames, count_causes(result.cause));
  if (result.pmd_loss) {
    report["pmd_loss"] = {{"cause", result.pmd_loss->cause},
                          {"percent", json_number(result.pmd_loss->share, kPercent)}};
  }
  return report;
}

void print_row(const char* name, const DepthScore& score) {
  std::printf("%-8s %7.4f  %7s %%  %8.1f mm %s %%  %s %%  %8.1f mm  %s %% ", name, score.e5,
              percent_text(score.coverage, 7).c_str(), score.median_error_m.value_or(0) * kMm,
              percent_text(score.median_relative, 6).c_str(),
              percent_text(score.hit_rate, 7).c_str(), score.median_width_m.value_or(0) * kMm,
              percent_text(score.median_width_relative, 6).c_str());
  for (const std::optional<double>& rate : score.hit_rate_by_width) {
    std::printf(" %s", percent_text(rate, 6).c_str());
  }
  std::printf("\n");
}

template <std::size_t kCount>
void print_shares(const char* what, const std::array<const char*, kCount>& names,
                  const std::array<std::size_t, kCount>& numbers, std::size_t pixels) {
  std::printf("%s", what);
  for (std::size_t i = 0; i < kCount; ++i) {
    const double share = static_cast<double>(numbers[i]) / static_cast<double>(pixels);
    std::printf("%s %s %s %%", i == 0 ? "" : ",", names[i], percent_text(share, 1).c_str());
  }
  std::printf("\n");
}

void print_source(const char* name, const SourceScore& score) {
  std::printf("%-9s %s %%  %s %%  %s %%  %s %%\n", name, percent_text(score.share, 6).c_str(),
              percent_text(score.hit_rate, 7).c_str(), percent_text(score.off, 9).c_str(),
              percent_text(score.collisions, 9).c_str());
}

// Sources without a depth are left out.
void print_sources(const FusionScores& scores) {
  std::printf("\n%-9s %8s  %9s  %11s  %s\n", "fused", "share", "hit rate", "off by 5 %",
              "nearer than told by over 1 m");
  for (std::size_t k = 0; k < scores.by_source.size(); ++k) {
    if (scores.by_source[k].share > 0) {
      print_source(client::kSourceNames[k], scores.by_source[k]);
    }
  }
  const DepthScore& all = scores.fused;
  print_source("all",
               {.share = all.coverage,
                .off = all.coverage > 0 ? std::optional((all.e5 - 1 + all.coverage) / all.coverage)
                                        : std::nullopt,
                .hit_rate = all.hit_rate,
                .collisions = all.collisions});
}

// Why the PMD camera covers nothing, where it does not.
void print_loss(const FusionCase& fused) {
  constexpr double kNothing = 0.005;
  if (fused.scores.pmd.coverage >= kNothing) {
    return;
  }
  const PmdLoss loss = fused.result.pmd_loss.value_or(PmdLoss{});
  if (loss.share < 1.0 / 2) {
    std::printf(
        "%s: the PMD camera covers nothing: its distances lie outside of the left picture, "
        "or beyond --max-range\n",
        fused.recording.c_str());
    return;
  }
  std::printf("%s: the PMD camera covers nothing: %s %% of its pixels are %s\n",
              fused.recording.c_str(), percent_text(loss.share, 1).c_str(), loss.cause);
}

void print_scene_head() {
  std::printf("%-12s %-9s %-23s %8s %9s %9s %7s %8s %8s  %-27s %s\n", "", "",
              "E5: pmd  stereo   fused", "coverage", "error, mm", "width, mm", "% of Z", "hit rate",
              "", "by quarters of width", "best");
}

void print_scene_row(const std::string& name, const std::string& sensor, const FusionScores& scores,
                     const char* best) {
  const DepthScore& fused = scores.fused;
  std::printf("%-12s %-9s %7.4f %7.4f %7.4f %8s %9.1f %9.1f %7s %8s %8s ", name.c_str(),
              sensor.c_str(), scores.pmd.e5, scores.stereo.e5, fused.e5,
              percent_text(fused.coverage, 8).c_str(), fused.median_error_m.value_or(0) * kMm,
              fused.median_width_m.value_or(0) * kMm,
              percent_text(fused.median_width_relative, 7).c_str(),
              percent_text(fused.hit_rate, 8).c_str(), "");
  for (const std::optional<double>& rate : fused.hit_rate_by_width) {
    std::printf(" %s", percent_text(rate, 6).c_str());
  }
  std::printf(" %s\n", best);
}

void print_chapter_row(const std::string& name, const std::string& sensor,
                       const FusionScores& scores) {
  std::printf("%-12s %-9s %15.4f %15.4f %15.4f %15.4f\n", name.c_str(), sensor.c_str(),
              scores.chapter_pmd->e5, scores.chapter_fused->e5, scores.reprojected->e5,
              scores.fused.e5);
}

void print_chapter(std::span<const FusionCase> cases) {
  if (!cases.front().scores.chapter_fused) {
    return;
  }
  std::printf("\nE5 of the chapter's geometry (a scaled PMD map), and of what replaces it\n");
  std::printf("%-12s %-9s %15s %15s %15s %15s\n", "", "", "scaled pmd", "scaled, fused",
              "full geometry", "and resolved");
  for (const FusionCase& fused : cases) {
    print_chapter_row(fused.scene, fused.sensor(), fused.scores);
  }
  if (cases.size() > 1) {
    print_chapter_row("mean", "", mean_of_sensor(cases, ""));
  }
}

}  // namespace

void print_fusion_text(const FusionCase& fused, const MatchRequest& match) {
  const FusionResult& result = fused.result;
  std::printf("%s with %s (%s); %s; ms: match %.2f, convert %.2f, fuse %.2f\n", fused.scene.c_str(),
              fused.recording.c_str(), fused.sensor().c_str(), describe(match).c_str(),
              result.match_ms, result.convert_ms, result.fuse_ms);
  std::printf("%s\n", kE5);
  std::printf("%-8s %7s  %9s  %20s  %9s  %11s  %8s  %s\n", "", "E5", "coverage", "median error",
              "hit rate", "median width", "of Z", "hit rate by quarters of width");
  print_row("pmd", fused.scores.pmd);
  print_row("stereo", fused.scores.stereo);
  print_row("fused", fused.scores.fused);
  print_loss(fused);
  const std::size_t pixels = result.source.pixels.size();
  print_shares("\nsources:", client::kSourceNames, count_sources(result.source), pixels);
  print_shares("causes: ", client::kCauseNames, count_causes(result.cause), pixels);
  print_sources(fused.scores);
  print_chapter({&fused, 1});
}

void print_fusion_json(const FusionCase& fused, const MatchRequest& match) {
  std::printf("%s\n", to_json(fused, match).dump(2).c_str());
}

void print_fusion_text(std::span<const FusionCase> cases, const MatchRequest& match) {
  std::printf("%s\n%s\n", describe(match).c_str(), kE5);
  print_scene_head();
  for (const FusionCase& fused : cases) {
    print_scene_row(fused.scene, fused.sensor(), fused.scores,
                    fused.scores.fused_is_best() ? "yes" : "no");
  }
  const std::vector<std::string> sensors = sensors_of(cases);
  for (const std::string& sensor : sensors) {
    if (sensors.size() > 1) {
      print_scene_row("mean", sensor, mean_of_sensor(cases, sensor), "");
    }
  }
  const auto best = std::ranges::count_if(
      cases, [](const FusionCase& fused) { return fused.scores.fused_is_best(); });
  const std::string tally = std::to_string(best) + " of " + std::to_string(cases.size());
  print_scene_row("mean", "", mean_of_sensor(cases, ""), tally.c_str());
  std::ranges::for_each(cases, print_loss);
  print_sources(mean_of_sensor(cases, ""));
  print_chapter(cases);
}

void print_fusion_json(std::span<const FusionCase> cases, const MatchRequest& match) {
  ordered_json report{{"scenes", ordered_json::array()}};
  for (const FusionCase& fused : cases) {
    report["scenes"].push_back(to_json(fused, match));
  }
  add_scores(mean_of_sensor(cases, ""), report["mean"]);
  for (const std::string& sensor : sensors_of(cases)) {
    add_scores(mean_of_sensor(cases, sensor), report["mean_by_sensor"][sensor]);
  }
  std::printf("%s\n", report.dump(2).c_str());
}

}  // namespace stof::host
