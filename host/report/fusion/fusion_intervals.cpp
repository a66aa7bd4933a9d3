// What intervals and geometry are worth, over all fused scenes.
#include "host/report/fusion/fusion_intervals.h"

#include <algorithm>
#include <cmath>

#include "host/report/page/plot.h"
#include "host/text/printed.h"

namespace stof::host {
namespace {

constexpr double kLeastHitRate = 0.9;

std::vector<IntervalCheck> pooled_checks(std::span<const FusionCase> cases,
                                         const std::string& sensor) {
  std::vector<IntervalCheck> all;
  for (const FusionCase& fused : cases) {
    if (fused.sensor() == sensor) {
      const std::vector<IntervalCheck> some = check_intervals(fused.result.fused, fused.truth);
      all.insert(all.end(), some.begin(), some.end());
    }
  }
  return all;
}

std::vector<std::string> interval_row(const std::string& name, const std::string& sensor,
                                      const DepthScore& score) {
  std::vector<std::string> row{name, sensor,
                               score.median_width_m ? number(*score.median_width_m * kMm, 1) : "–",
                               percent(score.median_width_relative, 2), percent(score.hit_rate)};
  for (const std::optional<double>& rate : score.hit_rate_by_width) {
    row.push_back(percent(rate));
  }
  return row;
}

Figure reliability(std::span<const FusionCase> cases) {
  constexpr int kParts = 10;
  constexpr std::array<Rgb, 3> kColours{kPlotBlue, kPlotOrange, kPlotGreen};
  Plot plot{.title = "Reliability of the intervals",
            .x_label = "intervals ordered by width, percent: narrow to wide",
            .y_label = "hold the truth, percent",
            .series = {}};
  double least = 70;
  const std::vector<std::string> sensors = sensors_of(cases);
  for (std::size_t s = 0; s < sensors.size(); ++s) {
    PlotSeries series{
        .name = "PMD " + sensors[s], .colour = kColours[s % kColours.size()], .dot_px = 5};
    const std::vector<std::optional<double>> rates =
        hit_rates_by_width(pooled_checks(cases, sensors[s]), kParts);
    for (int part = 0; part < kParts; ++part) {
      const std::optional<double> rate = rates[static_cast<std::size_t>(part)];
      series.add(100 * (part + 0.5) / kParts, rate ? 100 * *rate : std::nan(""));
      least = std::min(least, rate ? 100 * *rate : least);
    }
    plot.series.push_back(std::move(series));
  }
  plot.series.push_back({.name = "95 percent", .colour = kPlotGrey, .x = {0, 100}, .y = {95, 95}});
  plot.y_least = std::floor(least / 10) * 10;
  plot.y_most = 100;
  return plot_figure(plot,
                     "Does the truth lie in the published interval? All scenes of a PMD camera "
                     "together, a tenth of the intervals at each dot. "
                     "Meant are 95 percent, at every width.");
}

}  // namespace

void add_fusion_intervals(std::span<const FusionCase> cases, Page& page) {
  page.begin_section("intervals", "What the intervals are worth");
  Table table{
      .caption = "Published intervals of the fused depth; shares in percent",
      .header = {"Scene", "PMD camera", "median width, mm", "of the depth", "hold the truth",
                 "narrowest quarter", "second", "third", "widest quarter"},
      .text_columns = 2};
  int honest = 0;
  double least = 1;
  for (const FusionCase& fused : cases) {
    const DepthScore& score = fused.scores.fused;
    table.rows.push_back(interval_row(fused.scene, fused.sensor(), score));
    honest += score.hit_rate.value_or(0) >= kLeastHitRate ? 1 : 0;
    least = std::min(least, score.hit_rate.value_or(0));
  }
  for (const std::string& sensor : sensors_of(cases)) {
    table.rows.push_back(interval_row("mean", sensor, mean_of_sensor(cases, sensor).fused));
  }
  page.claim({.chapter = "The intersection of both intervals bounds the true depth.",
              .measured = percent(mean_of_sensor(cases, "").fused.hit_rate) +
                          " percent of the covered pixels hold the truth in the mean, " +
                          percent(least) + " in the worst case; meant are 95.",
              .rule = "yes: at least 90 percent in every case; partly: in some.",
              .verdict = verdict_of(honest, static_cast<int>(cases.size()))});
  page.figures({reliability(cases)}, Width::kLarge);
  page.table(table);
}

void add_fusion_geometry(std::span<const FusionCase> cases, Page& page) {
  if (!cases.front().scores.chapter_fused) {
    return;
  }
  page.begin_section("geometry", "What full geometry gains");
  page.paragraph(
      "The chapter scales the PMD map by factors until it fits the left picture. Here it is also "
      "carried there by the rotation and translation between the cameras and both camera models. "
      "Both are then fused by the interval rule alone; the appliance goes on and resolves what "
      "only "
      "one sensor saw.");
  Table table{.caption = "E5 in percent",
              .header = {"Scene", "PMD camera", "stereo alone", "PMD alone, scaled",
                         "PMD alone, full geometry", "fused, scaled",
                         "fused, full geometry, interval rule", "fused, the appliance"},
              .text_columns = 2};
  const auto row = [&table](const std::string& name, const std::string& sensor,
                            const FusionScores& scores) {
    table.rows.push_back({name, sensor, percent(scores.stereo.e5), percent(scores.chapter_pmd->e5),
                          percent(scores.pmd.e5), percent(scores.chapter_fused->e5),
                          percent(scores.reprojected->e5), percent(scores.fused.e5)});
  };
  int suffices = 0;
  for (const FusionCase& fused : cases) {
    row(fused.scene, fused.sensor(), fused.scores);
    suffices += fused.scores.chapter_fused->e5 < fused.scores.stereo.e5 &&
                        fused.scores.chapter_fused->e5 < fused.scores.chapter_pmd->e5
                    ? 1
                    : 0;
  }
  for (const std::string& sensor : sensors_of(cases)) {
    row("mean", sensor, mean_of_sensor(cases, sensor));
  }
  const FusionScores mean = mean_of_sensor(cases, "");
  page.claim({.chapter = "Scaling the PMD map by factors brings it into the stereo picture.",
              .measured = "Fused so, E5 is " + percent(mean.chapter_fused->e5) +
                          " percent in the mean; with full geometry and the same rule " +
                          percent(mean.reprojected->e5) + ", with stereo alone " +
                          percent(mean.stereo.e5) + ".",
              .rule = "yes: fused so, E5 is below that of each sensor in every case; partly: in "
                      "some.",
              .verdict = verdict_of(suffices, static_cast<int>(cases.size()))});
  page.table(table);
}

}  // namespace stof::host
