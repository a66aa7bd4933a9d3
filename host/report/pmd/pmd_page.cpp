#include "host/report/pmd/pmd_page.h"

#include <cmath>

#include "host/evaluate/stereo/median.h"
#include "host/report/pmd/pmd_pictures.h"
#include "host/report/pmd/pmd_plots.h"
#include "host/text/printed.h"

namespace stof::host {
namespace {

std::string named(const char* what, const std::filesystem::path& folder, std::size_t studies) {
  return studies > 1 ? std::string(what) + " (" + folder.filename().string() + ")" : what;
}

Table wall_table(const PmdReport& report) {
  Table table{.caption =
                  "Mean error of Z over the middle of the picture, and the spread of a "
                  "reading from frame to frame.",
              .header = {"recording", "Z, m", "line alone, mm", "%", "calibrated, mm", "%",
                         "valid, %", "sigma measured, cm", "sigma said, cm"}};
  for (const WallRow& row : report.rows) {
    const double line = row.line_error_m;
    const double full = row.view.error_m;
    table.rows.push_back(
        {row.name, number(row.z_m, 2), number(line * kMm, 1), number(line / row.z_m * kPercent, 3),
         number(full * kMm, 1), number(full / row.z_m * kPercent, 3), percent(row.view.valid, 0),
         number(row.view.spread_m * kCm, 2), number(row.view.predicted_m * kCm, 2)});
  }
  return table;
}

std::string judged_by(const WallStudy& study) {
  if (study.given) {
    return "those of the calibration file, judged on all frames";
  }
  return study.report.judged == Frames::kAll
             ? "fitted to all frames and judged on the same"
             : "fitted to some of the frames and judged on the others";
}

void add_wall(const WallStudy& study, const std::string& id, std::size_t studies, Page& page) {
  page.begin_section(id, named("Walls at known distances", study.folder, studies));
  page.paragraph("A wall facing the camera. Constants are " + judged_by(study) +
                 "; every figure is of the appliance's own fixed-point conversion.");
  page.table(wall_table(study.report));
  page.figures(noise_figures(study.report, study.calibration), Width::kLarge);
  page.figures(calibration_figures(study.report, study.calibration), Width::kMedium);
  page.figures(ratio_figures(study), Width::kMedium);
  page.figures(mask_figures(study), Width::kMedium);
  page.figures(flat_wall_figures(study), Width::kMedium);
  const std::optional<LineFit>& line = study.calibration.line;
  page.claim({.chapter = "A straight line from phase to distance errs by up to 3 percent",
              .measured = line ? "the line alone errs by up to " +
                                     percent(line->worst_relative, 2) + " percent from " +
                                     number(line->from_m, 1) + " m on; all constants by up to " +
                                     percent(study.report.worst_relative, 3) + " percent"
                               : "no line could be fitted",
              .rule = "the line's largest error is at most 3 percent",
              .verdict = !line ? Verdict::kNotMeasured
                               : verdict_of(line->worst_relative <= 0.03 ? 1 : 0, 1)});
}

void add_stray(const WallStudy& study, const std::string& id, std::size_t studies, Page& page) {
  page.begin_section(id, named("A wall with stray light", study.folder, studies));
  page.paragraph("Light that comes back inside the camera: the calibration finds I " +
                 number(study.stray_i_lsb, 1) + " and Q " + number(study.stray_q_lsb, 1) +
                 " LSB, as of a surface at " + number(study.stray_apparent_m, 2) + " m.");
  Table table{.caption =
                  "Mean Z of the middle less the wall's, by the recording's constants and "
                  "with the phasor subtracted.",
              .header = {"recording", "Z, m", "before, mm", "valid, %", "low ratio, %", "after, mm",
                         "valid, %"}};
  bool falls = false;
  bool falls_after = false;
  double last = 0;
  double last_after = 0;
  for (const StrayRow& row : study.stray) {
    table.rows.push_back({row.name, number(row.z_m, 2), number(row.before.error_m * kMm, 1),
                          percent(row.before.valid, 0), percent(row.before.flagged[3], 0),
                          number(row.after.error_m * kMm, 1), percent(row.after.valid, 0)});
    const double seen = row.z_m + row.before.error_m;
    falls |= seen < last;
    last = std::isfinite(seen) ? seen : last;
    const double left = row.z_m + row.after.error_m;
    falls_after |= left < last_after;
    last_after = std::isfinite(left) ? left : last_after;
  }
  page.table(table);
  page.figures(stray_figures(study), Width::kMedium);
  page.claim(
      {.chapter = "Readings of a smooth wall fall again beyond some 3 m",
       .measured =
           std::string(falls ? "with stray light they do" : "with stray light they do not") +
           (falls_after ? "; with it subtracted they do" : "; with it subtracted they do not"),
       .rule = "a farther wall reads nearer, with the recording's own constants",
       .verdict = verdict_of(falls ? 1 : 0, 1)});
}

void add_lights(const LightStudy& study, const std::string& id, std::size_t studies, Page& page) {
  page.begin_section(id, named("A light beside the lens", study.folder, studies));
  Table table{.caption = "Mean of |mean radial error| over the frames, mm.",
              .header = {"recording", "Z, m", "at the lens: pixels", "blocks", "near model: pixels",
                         "blocks"}};
  for (const LightRow& row : study.rows) {
    table.rows.push_back({row.name, number(row.z_m, 2), number(row.before_m * kMm, 1),
                          number(row.before_blocks_m * kMm, 1), number(row.after_m * kMm, 1),
                          number(row.after_blocks_m * kMm, 1)});
  }
  page.table(table);
  page.figures(light_figures(study), Width::kLarge);
}

std::vector<std::string> counts_row(const std::string& name, const EdgeCounts& c) {
  return {
      name,
      std::to_string(c.mixed_with_depth),
      percent(share(c.mixed_flagged, c.mixed_with_depth)),
      percent(share(c.holding, c.mixed_with_depth)),
      std::to_string(c.pure_with_depth),
      percent(share(c.pure_flagged, c.pure_with_depth)),
      number(c.pure_error_m.empty() ? std::nullopt : std::optional(*median(c.pure_error_m) * kMm),
             1),
      percent(c.pure_error_m.empty() ? std::nullopt : share(c.pure_holding, c.pure_with_depth))};
}

void add_edges(const EdgeStudy& study, const std::string& id, const std::string& title,
               int around_px, Page& page) {
  page.begin_section(id, title);
  Table table{.caption =
                  "Pixels that carry a depth, in all frames. Mixed ones see two surfaces; "
                  "the interval of a mixed one should hold both, of a pure one its middle.",
              .header = {"recording", "mixed", "flagged, %", "interval holds both, %", "pure",
                         "flagged, %", "median error, mm", "interval holds it, %"}};
  for (const EdgeRow& row : study.rows) {
    table.rows.push_back(counts_row(row.name, row.counts));
  }
  table.rows.push_back(counts_row("all", study.all));
  page.table(table);
  if (study.marks.pixels.empty()) {
    return;
  }
  page.figures({section_figure(study, around_px)}, Width::kLarge);
  page.figures({marks_figure(study), height_field_figure(study)}, Width::kMedium);
  page.claim({.chapter = "At an edge the true value lies between the readings of the neighbours",
              .measured = percent(share(study.all.holding, study.all.mixed_with_depth), 2) +
                          " percent of the intervals of mixed pixels hold both surfaces",
              .rule = "all of them do; partly: 95 percent",
              .verdict = verdict_of(
                  (study.all.holding == study.all.mixed_with_depth ? 1 : 0) +
                      (20 * study.all.holding >= 19 * study.all.mixed_with_depth ? 1 : 0),
                  study.all.mixed_with_depth == 0 ? 0 : 2)});
}

void add_frequencies(const FrequencyStudy& study, const std::string& id, std::size_t studies,
                     Page& page) {
  page.begin_section(id, named("Two modulation frequencies", study.folder, studies));
  Table table{.caption = "Readings beyond one turn. Wrong: off by half a turn or more.",
              .header = {"recording", "MHz", "period, m", "wall, m", "accepted, %", "wrong",
                         "median error, mm"}};
  for (const FrequencyRow& row : study.rows) {
    table.rows.push_back({row.name, number(row.first_mhz, 2) + " + " + number(row.second_mhz, 2),
                          number(row.period_m, 2),
                          number(row.nearest_m, 1) + " to " + number(row.farthest_m, 1),
                          percent(share(row.accepted, row.pixels)), std::to_string(row.wrong),
                          number(row.median_error_m * kMm, 1)});
  }
  page.table(table);
}

void add_frame(const FrameStudy& study, const std::string& id, std::size_t studies, Page& page) {
  page.begin_section(id, named("A frame of a real camera", study.folder, studies));
  page.paragraph(
      "Radial distances of an ifm O3R camera, " + std::to_string(study.width) + " by " +
      std::to_string(study.height) +
      " px, through the appliance's rays: off a cloud in double "
      "precision by " +
      number(study.exact.largest_m * kMm, 3) + " mm at most." +
      (study.has_cartesian ? "" : " Its buffer holds no Cartesian images to compare with.") +
      " Noise that falls with the amplitude, as the appliance models it, and the camera's own "
      "noise "
      "image have a rank correlation of " +
      number(study.rank_correlation, 3) + ".");
  page.figures(cloud_figures(study), Width::kMedium);
}

void add_sections(const PmdEvaluation& evaluation, Page& page) {
  int n = 0;
  const auto id = [&n] { return "part" + std::to_string(++n); };
  const auto count = [](const auto& studies) { return studies.size(); };
  for (const WallStudy& study : evaluation.walls) {
    if (study.stray.empty()) {
      add_wall(study, id(), count(evaluation.walls), page);
    } else {
      add_stray(study, id(), 1, page);
    }
  }
  for (const LightStudy& study : evaluation.lights) {
    add_lights(study, id(), count(evaluation.lights), page);
  }
  constexpr int kAroundEdge = 8;
  for (const EdgeStudy& study : evaluation.edges) {
    add_edges(study, id(), named("An edge", study.folder, count(evaluation.edges)), kAroundEdge,
              page);
  }
  for (const FrequencyStudy& study : evaluation.frequencies) {
    add_frequencies(study, id(), count(evaluation.frequencies), page);
  }
  constexpr int kAroundScene = 40;
  for (const EdgeStudy& study : evaluation.scenes) {
    add_edges(study, id(), named("Scenes", study.folder, count(evaluation.scenes)), kAroundScene,
              page);
  }
  for (const FrameStudy& study : evaluation.frames) {
    add_frame(study, id(), count(evaluation.frames), page);
  }
}

}  // namespace

std::expected<void, dataset::Problem> write_pmd_page(const PmdEvaluation& evaluation,
                                                     const std::filesystem::path& file) {
  Page page;
  add_sections(evaluation, page);
  const std::vector<std::string> lead{
      "The time-of-flight half of the 2006 book chapter on fusing stereo and PMD depth for mobile "
      "robots (Kuhnert & Stommel), measured with the converter of the stof appliance, which "
      "computes in integers. Recordings come from a simulator unless a section says otherwise.",
      "Phase of " + std::to_string(evaluation.phase.pixels) + " random samples: off by " +
          number(evaluation.phase.largest_lsb, 3) +
          " LSB at most (65536 a turn); plain and vector kernels are " +
          (evaluation.phase.kernels_equal ? "equal." : "NOT equal.")};
  return write_page(file, page.html("The chapter's PMD, measured", lead));
}

std::expected<void, dataset::Problem> write_calibration_page(const PmdReport& report,
                                                             const PmdCalibration& calibration,
                                                             const std::filesystem::path& file) {
  Page page;
  page.begin_section("walls", "Walls at known distances");
  page.table(wall_table(report));
  page.figures(noise_figures(report, calibration), Width::kLarge);
  page.figures(calibration_figures(report, calibration), Width::kMedium);
  page.begin_section("constants", "Constants");
  page.figures(wiggling_figures(calibration), Width::kLarge);
  page.figures(pattern_figures(calibration), Width::kLarge);
  return write_page(file, page.html("A PMD camera, calibrated",
                                    {"Walls of " + report.folder +
                                     ", measured with the converter of the stof appliance."}));
}

}  // namespace stof::host
