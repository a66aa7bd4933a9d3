// Tables and claims over all fused scenes.
#include "host/report/fusion/fusion_summary.h"

#include <algorithm>
#include <cmath>

#include "host/report/fusion/fusion_figures.h"
#include "host/text/printed.h"

namespace stof::host {
namespace {

constexpr double kLargestConflictShare = 0.05;
constexpr double kLeastCoverage = 0.9;
constexpr double kLeastRight = 0.5;

std::string name_of(const FusionCase& fused) { return fused.scene + " " + fused.sensor(); }

std::optional<double> millimetres(std::optional<double> metres) {
  return metres ? std::optional(*metres * kMm) : std::nullopt;
}

std::vector<std::string> score_row(const std::string& name, const std::string& sensor,
                                   const FusionScores& scores, const std::string& better) {
  const DepthScore& fused = scores.fused;
  return {name,
          sensor,
          percent(scores.pmd.e5),
          percent(scores.stereo.e5),
          percent(fused.e5),
          better,
          percent(scores.stereo.coverage),
          percent(fused.coverage),
          number(millimetres(fused.median_error_m), 1),
          percent(fused.median_relative, 2)};
}

void add_scores(std::span<const FusionCase> cases, Page& page) {
  Table table{.caption = "All pixels with truth; shares in percent",
              .header = {"Scene", "PMD camera", "E5, PMD alone", "E5, stereo alone", "E5, fused",
                         "better than each", "covered by stereo", "covered, fused",
                         "median error, mm", "of the depth"},
              .text_columns = 2};
  for (const FusionCase& fused : cases) {
    table.rows.push_back(score_row(fused.scene, fused.sensor(), fused.scores,
                                   fused.scores.fused_is_best() ? "yes" : "no"));
  }
  for (const std::string& sensor : sensors_of(cases)) {
    table.rows.push_back(score_row("mean", sensor, mean_of_sensor(cases, sensor), ""));
  }
  page.table(table);
}

void claim_better(std::span<const FusionCase> cases, Page& page) {
  int better = 0;
  std::string exceptions;
  for (const FusionCase& fused : cases) {
    better += fused.scores.fused_is_best() ? 1 : 0;
    if (!fused.scores.fused_is_best()) {
      add_to(exceptions, name_of(fused), "; ");
    }
  }
  const FusionScores mean = mean_of_sensor(cases, "");
  std::string measured = "E5 is " + percent(mean.pmd.e5) + " percent with the PMD alone, " +
                         percent(mean.stereo.e5) + " with stereo alone, " + percent(mean.fused.e5) +
                         " with both, in the mean; lowest with both in " + std::to_string(better) +
                         " of " + std::to_string(cases.size()) + " cases.";
  if (!exceptions.empty()) {
    measured += " Not in: " + exceptions + ".";
  }
  page.claim({.chapter = "Fused depth is better than that of either sensor alone.",
              .measured = measured,
              .rule = "yes: fused E5 is below that of each sensor in every case; partly: in some.",
              .verdict = verdict_of(better, static_cast<int>(cases.size()))});
}

// What became of the pixels with truth that stereo left empty.
struct Gaps {
  std::size_t truth = 0;
  std::size_t empty = 0;
  std::size_t covered = 0;
  std::size_t right = 0;

  bool dense() const {
    return share(covered, empty).value_or(0) >= kLeastCoverage &&
           share(right, empty).value_or(0) >= kLeastRight;
  }
};

Gaps gaps_of(const FusionCase& fused) {
  Gaps gaps;
  for (std::size_t i = 0; i < fused.truth.pixels.size(); ++i) {
    const double z = fused.truth.pixels[i];
    if (!std::isfinite(z)) {
      continue;
    }
    ++gaps.truth;
    if (std::isfinite(fused.result.stereo.depth.pixels[i])) {
      continue;
    }
    ++gaps.empty;
    const double depth = fused.result.fused.depth.pixels[i];
    gaps.covered += std::isfinite(depth) ? 1U : 0U;
    gaps.right += std::abs(depth - z) <= kLargestRelativeError * z ? 1U : 0U;
  }
  return gaps;
}

void add_gaps(std::span<const FusionCase> cases, Page& page) {
  Table table{.caption = "Pixels with truth that stereo alone leaves empty; shares in percent",
              .header = {"Scene", "PMD camera", "empty, of all", "then covered by the fusion",
                         "then right within 5 percent"},
              .text_columns = 2};
  int dense = 0;
  int judged = 0;
  std::string list;
  for (const FusionCase& fused : cases) {
    const Gaps gaps = gaps_of(fused);
    if (gaps.empty == 0) {
      continue;
    }
    ++judged;
    dense += gaps.dense() ? 1 : 0;
    add_to(list,
           name_of(fused) + ": " + percent(share(gaps.covered, gaps.empty), 0) +
               " percent covered, " + percent(share(gaps.right, gaps.empty), 0) + " percent right",
           "; ");
    table.rows.push_back({fused.scene, fused.sensor(), percent(share(gaps.empty, gaps.truth)),
                          percent(share(gaps.covered, gaps.empty)),
                          percent(share(gaps.right, gaps.empty))});
  }
  page.claim({.chapter = "Where stereo finds no texture the PMD makes the depth map dense.",
              .measured = list.empty() ? "Stereo left nothing empty." : list + ".",
              .rule = "yes: in every case at least 90 percent of what stereo leaves empty is "
                      "covered, and at least half of it is within 5 percent of the true depth; "
                      "partly: in some.",
              .verdict = verdict_of(dense, judged)});
  page.table(table);
}

void add_sources(std::span<const FusionCase> cases, Page& page) {
  Table table{.caption = "Where depths come from; percent of all pixels",
              .header = {"Scene", "PMD camera", "both agree", "stereo alone", "PMD alone",
                         "resolved", "conflict", "none"},
              .text_columns = 2};
  Table causes{.caption = "Why depths were resolved or left out; percent of all pixels",
               .header = {"Scene", "PMD camera"},
               .text_columns = 2};
  causes.header.insert(causes.header.end(), kCauseMeanings.begin() + 1, kCauseMeanings.end());
  int rare = 0;
  double most = 0;
  for (const FusionCase& fused : cases) {
    const std::array<std::size_t, dsp::kSources> sources = count_sources(fused.result.source);
    const std::size_t pixels = fused.result.source.pixels.size();
    std::vector<std::string> row{fused.scene, fused.sensor()};
    for (const dsp::Source source :
         {dsp::Source::kBoth, dsp::Source::kStereo, dsp::Source::kPmd, dsp::Source::kResolved,
          dsp::Source::kConflict, dsp::Source::kNone}) {
      row.push_back(percent(share(sources.at(static_cast<std::size_t>(source)), pixels)));
    }
    table.rows.push_back(std::move(row));
    std::vector<std::string> cause_row{fused.scene, fused.sensor()};
    const std::array<std::size_t, dsp::kCauses> numbers = count_causes(fused.result.cause);
    for (std::size_t i = 1; i < numbers.size(); ++i) {
      cause_row.push_back(percent(share(numbers[i], pixels)));
    }
    causes.rows.push_back(std::move(cause_row));
    const double conflict =
        share(sources.at(static_cast<std::size_t>(dsp::Source::kConflict)), pixels).value_or(0);
    rare += conflict <= kLargestConflictShare ? 1 : 0;
    most = std::max(most, conflict);
  }
  page.claim({.chapter = "Intervals that exclude each other are an exception; such pixels are "
                         "marked instead of guessed.",
              .measured = "At most " + percent(most) +
                          " percent of the pixels of a scene are conflicts without depth.",
              .rule = "yes: at most 5 percent of the pixels in every case; partly: in some.",
              .verdict = verdict_of(rare, static_cast<int>(cases.size()))});
  page.table(table);
  page.table(causes);
}

}  // namespace

void add_fusion_summary(std::span<const FusionCase> cases, Page& page) {
  page.begin_section("summary", "All scenes");
  claim_better(cases, page);
  add_scores(cases, page);
  add_gaps(cases, page);
  add_sources(cases, page);
}

}  // namespace stof::host
