// Simulated annealing against scanline optimisation: energy, time, bad pixels.
#include <cmath>

#include "host/evaluate/stereo/match.h"
#include "host/report/stereo/sections.h"
#include "host/text/printed.h"

namespace stof::host {
namespace {

constexpr double kSlow = 10;     // times the scanline's time
constexpr double kSlightly = 2;  // points of BP

struct Annealed {
  Outcome outcome;
  std::uint64_t energy = 0;
};

// One way to a dense map on one cost, with the energy of what it finds.
std::optional<Annealed> match(const Study& study, const dataset::StereoScene& scene,
                              lab::Method method, std::optional<lab::Acceptance> annealing) {
  MatchPlan plan;
  plan.params = lab::method_defaults(lab::Method::kScanlineOptimisation);
  plan.params.disparities = scene.ndisp;
  plan.params.method = method;
  plan.params.smoothness = lab::default_smoothness(lab::Cost::kSad);
  plan.annealing = annealing;
  plan.energy = true;
  plan.runs = annealing ? 1 : study.runs();
  const dataset::Loaded<MatchResult> result = match_scene(scene, plan);
  if (!result) {
    return std::nullopt;
  }
  Annealed found{.outcome = {}, .energy = result->energy.value_or(0)};
  found.outcome.disparity = to_pixels(result->disparity.view());
  found.outcome.ms = result->median_ms;
  found.outcome.score = score_disparity(found.outcome.disparity, scene, plan.params.block_width);
  return found;
}

std::string in_thousands(std::uint64_t energy) {
  return number(static_cast<double>(energy) / 1000, 0);
}

std::vector<std::string> row_of(const std::string& name, const Annealed& found) {
  return {name, in_thousands(found.energy), number(found.outcome.ms, 1),
          percent(found.outcome.score.all), percent(found.outcome.score.visible)};
}

// What all scenes say.
struct AnnealingTally {
  int judged = 0;
  int hold = 0;
  std::string list;

  void note(const std::string& scene, const Annealed& scanline, const Annealed& slow) {
    if (!headline(scanline.outcome.score)) {
      return;
    }
    const double gain = 100 * (*headline(scanline.outcome.score) - *headline(slow.outcome.score));
    const double times = slow.outcome.ms / scanline.outcome.ms;
    const double energy =
        1 - static_cast<double>(slow.energy) / static_cast<double>(scanline.energy);
    ++judged;
    hold += times > kSlow && gain > 0 && gain <= kSlightly ? 1 : 0;
    add_to(list,
           scene + ": " + number(times, 0) + " times as slow, energy " + percent(energy) +
               " percent lower, BP " + number(std::abs(gain), 1) +
               (gain < 0 ? " points worse" : " points better"),
           "; ");
  }
};

std::vector<Figure> add_annealing_scene(const Study& study, const Subject& subject, Table& table,
                                        AnnealingTally& tally) {
  const dataset::StereoScene& scene = subject.scene;
  std::vector<Figure> figures;
  const auto add = [&](const std::string& name, const Annealed& found) {
    table.rows.push_back(row_of(name, found));
    figures.push_back(map_figure(
        subject, found.outcome.disparity, scene.name + ", " + name,
        "Energy " + in_thousands(found.energy) + " thousand, " + in_words(found.outcome) + "."));
  };
  const std::optional<Annealed> winner =
      match(study, scene, lab::Method::kWinnerTakesAll, std::nullopt);
  const std::optional<Annealed> scanline =
      match(study, scene, lab::Method::kScanlineOptimisation, std::nullopt);
  if (!winner || !scanline) {
    return figures;
  }
  table.rows.push_back({scene.name});
  table.rows.push_back(row_of("winner takes all, where annealing begins", *winner));
  add("scanline optimisation", *scanline);
  if (const std::optional<Annealed> hill =
          match(study, scene, lab::Method::kWinnerTakesAll, lab::Acceptance::kHillClimbing)) {
    add("annealing, hill climbing", *hill);
  }
  if (const std::optional<Annealed> slow =
          match(study, scene, lab::Method::kWinnerTakesAll, lab::Acceptance::kMetropolis)) {
    add("annealing, Metropolis", *slow);
    tally.note(scene.name, *scanline, *slow);
  }
  return figures;
}

}  // namespace

void add_annealing(Study& study, Page& page) {
  page.begin_section("annealing", "Simulated annealing");
  page.paragraph(
      "Simulated annealing searches the whole picture for the map of lowest energy E = sum of "
      "costs + lambda times the sum of |d - d'| over neighbours, beginning with winner takes all. "
      "Here on SAD of derivatives in the block of the scanline optimisation, with its smoothness "
      "for one step; energies of all maps are of this E. It is an offline reference: the appliance "
      "does not run it.");
  Table table{.caption = "BP in percent",
              .header = {"Method", "energy, thousands", "ms", "BP all", "BP not occluded"}};
  AnnealingTally tally;
  std::vector<std::vector<Figure>> figures;
  for (const Subject& subject : study.subjects()) {
    figures.push_back(add_annealing_scene(study, subject, table, tally));
  }
  page.table(table);
  page.claim({.chapter = "Simulated annealing is slow and only slightly better.",
              .measured = tally.list.empty() ? "Nothing to compare." : tally.list + ".",
              .rule =
                  "yes: in every scene Metropolis takes more than ten times as long as scanline "
                  "optimisation and lowers its BP by at most 2 points; partly: in some.",
              .verdict = verdict_of(tally.hold, tally.judged)});
  for (const std::vector<Figure>& row : figures) {
    page.figures(row, Width::kMedium);
  }
}

}  // namespace stof::host
