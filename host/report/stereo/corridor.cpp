// The corridor pair of the emulated rig: disparity and depth.
#include <algorithm>
#include <cmath>

#include "host/evaluate/fusion/depth_score.h"
#include "host/evaluate/stereo/median.h"
#include "host/report/page/legend.h"
#include "host/report/stereo/sections.h"
#include "host/text/printed.h"

namespace stof::host {
namespace {

constexpr double kUsableError = 0.05;  // of the depth
constexpr double kUsableShare = 0.9;

// What is known about depth between two distances.
struct Band {
  double from_m;
  double to_m;
  int truth = 0;
  int covered = 0;
  int close = 0;  // within kUsableError
  std::vector<double> errors_m{};
};

std::vector<Band> bands_of(const dataset::Image<float>& depth, const dataset::Image<float>& truth) {
  std::vector<Band> bands{{0, 3}, {3, 4}, {4, 5}, {5, 6}, {6, 7}, {0, 100}};
  for (std::size_t i = 0; i < truth.pixels.size(); ++i) {
    const double z = truth.pixels[i];
    for (Band& band : bands) {
      if (!(z >= band.from_m && z < band.to_m)) {
        continue;
      }
      ++band.truth;
      if (std::isfinite(depth.pixels[i])) {
        const double error = std::abs(depth.pixels[i] - z);
        ++band.covered;
        band.close += error <= kUsableError * z ? 1 : 0;
        band.errors_m.push_back(error);
      }
    }
  }
  return bands;
}

// Too near, too far or right within kUsableError of the depth.
dataset::Image<Finding> depth_findings(const dataset::Image<float>& depth,
                                       const dataset::Image<float>& truth) {
  dataset::Image<Finding> findings(depth.width, depth.height);
  for (std::size_t i = 0; i < findings.pixels.size(); ++i) {
    const double error = depth.pixels[i] - truth.pixels[i];
    if (!std::isfinite(truth.pixels[i])) {
      findings.pixels[i] = Finding::kUnknown;
    } else if (!std::isfinite(depth.pixels[i])) {
      findings.pixels[i] = Finding::kMissing;
    } else if (std::abs(error) <= kUsableError * truth.pixels[i]) {
      findings.pixels[i] = Finding::kRight;
    } else {
      findings.pixels[i] = error < 0 ? Finding::kTooNear : Finding::kTooFar;
    }
  }
  return findings;
}

void add_rows(const std::string& name, const std::vector<Band>& bands, Table& table) {
  table.rows.push_back({name});
  for (const Band& band : bands) {
    if (band.truth == 0) {
      continue;
    }
    const bool whole = &band == &bands.back();
    const std::optional<double> error = median(band.errors_m);
    table.rows.push_back({whole ? "all" : number(band.from_m, 0) + " to " + number(band.to_m, 0),
                          percent(share(band.truth, bands.back().truth)),
                          percent(share(band.covered, band.truth)),
                          percent(share(band.close, band.covered)),
                          number(error ? std::optional(1000 * *error) : std::nullopt, 0)});
  }
}

struct Way {
  std::string name;
  std::optional<Outcome> outcome;
};

std::vector<Way> ways(Study& study, const dataset::StereoScene& scene) {
  lab::MatchParams chapter = block_match(scene, lab::Cost::kSad, 16, 16, true);
  chapter.left_right_tolerance = 1;
  chapter.subpixel = dsp::Subpixel::kEquiangular;
  std::vector<Way> result;
  const std::string name = "SAD 16 × 16, left-right check, 1/16 px";
  result.push_back({name, study.run(scene, {name, chapter})});
  for (const char* const named : {"fast", "quality"}) {
    lab::MatchParams params = preset(scene, named).value_or(chapter);
    params.subpixel =
        dsp::Subpixel::kEquiangular;  // as the appliance does: depth has no steps then
    const std::string title = std::string("preset ") + named + ", 1/16 px";
    result.push_back({title, study.run(scene, {title, params})});
  }
  std::erase_if(result, [](const Way& way) { return !way.outcome; });
  return result;
}

// What all ways say.
struct CorridorTally {
  int judged = 0;
  int usable = 0;
  std::string list;

  void note(const Way& way, const Band& all) {
    if (const std::optional<double> close = share(all.close, all.covered)) {
      ++judged;
      usable += *close >= kUsableShare ? 1 : 0;
      add_to(list,
             way.name + ": " + percent(close) +
                 " percent of the measured pixels are within 5 percent of the true depth, " +
                 percent(share(all.covered, all.truth), 0) + " percent are measured",
             "; ");
    }
  }
};

constexpr ColourScale kScale{.near_m = 1.8, .far_m = 7};

std::vector<Figure> pictures(const dataset::StereoScene& scene) {
  std::vector<Figure> figures{
      figure(scene.left, "Left picture",
             std::to_string(scene.left.width) + " × " + std::to_string(scene.left.height) + " px."),
      figure(scene.right, "Right picture", "The same moment.")};
  if (scene.truth) {
    figures.push_back(figure(metric_picture(depth_from_disparity(*scene.truth, *scene.rig), kScale),
                             "True depth", "Z in metres.", depth_legend(kScale)));
  }
  return figures;
}

std::vector<Figure> add_way(const Subject& subject, const Way& way, Table& table,
                            CorridorTally& tally) {
  const dataset::StereoScene& scene = subject.scene;
  const dataset::Image<float> depth = depth_from_disparity(way.outcome->disparity, *scene.rig);
  std::vector<Figure> figures{map_figure(subject, way.outcome->disparity, "Disparity, " + way.name,
                                         in_words(*way.outcome) + "."),
                              figure(metric_picture(depth, kScale), "Depth, " + way.name,
                                     "Z in metres.", depth_legend(kScale))};
  if (scene.truth) {
    const dataset::Image<float> truth = depth_from_disparity(*scene.truth, *scene.rig);
    figures.push_back(figure(finding_picture(depth_findings(depth, truth), scene.left, {}),
                             "Depth against the truth, " + way.name, "Right: within 5 percent.",
                             difference_legend()));
    const std::vector<Band> bands = bands_of(depth, truth);
    add_rows(way.name, bands, table);
    tally.note(way, bands.back());
  }
  return figures;
}

void add_views(const Study& study, const Subject& subject, const Way& way, Page& page) {
  std::vector<Figure> views{height_field_figure(subject, way.outcome->disparity,
                                                "2.5D view, computed", "By " + way.name + ".",
                                                study.quick())};
  if (subject.scene.truth) {
    views.push_back(height_field_figure(subject, *subject.scene.truth, "2.5D view of the truth",
                                        "The same point of view.", study.quick()));
  }
  page.figures(views, Width::kLarge);
}

}  // namespace

void add_corridor(Study& study, Page& page) {
  if (!study.corridor() || !study.corridor()->scene.rig) {
    return;
  }
  const Subject& subject = *study.corridor();
  const dataset::StereoScene& scene = subject.scene;
  const dsp::StereoRig& rig = *scene.rig;
  page.begin_section("corridor", "The corridor: disparity and depth");
  page.paragraph(
      "The chapter's robot looks down a corridor with a person in it; this one is rendered, with "
      "noise, by the emulated rig, so that its depth is known exactly: focal length " +
      number(rig.left.fx, 0) + " px, baseline " + number(1000 * rig.baseline_m, 0) +
      " mm, Z = f b / d. White walls give stereo nothing to match; what it cannot measure is left "
      "out, not guessed.");
  Table table{.caption = "Depth Z against the truth, by true distance; shares in percent",
              .header = {"Distance, m", "of the picture", "measured", "of the measured, within 5 %",
                         "median error, mm"}};
  CorridorTally tally;
  const std::vector<Way> all = ways(study, scene);
  std::vector<std::vector<Figure>> figures{pictures(scene)};
  for (const Way& way : all) {
    figures.push_back(add_way(subject, way, table, tally));
  }
  page.claim({.chapter = "The corridor pair gives depth that a robot can use.",
              .measured = tally.list.empty() ? "Nothing to judge." : tally.list + ".",
              .rule = "yes: at least 90 percent of the measured pixels are within 5 percent of the "
                      "true depth, by every way shown; partly: by some.",
              .verdict = verdict_of(tally.usable, tally.judged)});
  for (const std::vector<Figure>& row : figures) {
    page.figures(row, Width::kMedium);
  }
  page.table(table);
  if (!all.empty()) {
    add_views(study, subject, all.back(), page);
  }
}

}  // namespace stof::host
