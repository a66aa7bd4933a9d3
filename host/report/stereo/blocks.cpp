// Block sizes with the left-right check.
#include <algorithm>

#include "host/report/page/legend.h"
#include "host/report/stereo/sections.h"

namespace stof::host {
namespace {

constexpr int kTolerancePx = 1;
constexpr double kMost = 0.5;

struct Checked {
  std::optional<Outcome> dense;
  std::optional<Outcome> checked;
};

Checked match(Study& study, const dataset::StereoScene& scene, int width, int height) {
  lab::MatchParams params = block_match(scene, lab::Cost::kSad, width, height, true);
  const std::string name = "SAD " + std::to_string(width) + " × " + std::to_string(height);
  Checked result{.dense = study.run(scene, {name, params}), .checked = {}};
  params.left_right_tolerance = kTolerancePx;
  result.checked = study.run(scene, {name + ", left-right check", params});
  return result;
}

std::vector<std::string> table_row(const std::string& name, const Checked& both,
                                   const dataset::StereoScene& scene) {
  const DisparityScore& score = both.checked->score;
  std::vector<std::string> row{name, number(both.checked->ms, 2), percent(score.density),
                               percent(score.of_valid), percent(score.visible)};
  const std::optional<Removal> gone =
      scene.truth
          ? std::optional(removal(both.dense->disparity, both.checked->disparity, *scene.truth))
          : std::nullopt;
  row.push_back(percent(gone ? gone->wrong_before : std::nullopt));
  row.push_back(percent(gone ? gone->removed_of_wrong : std::nullopt));
  row.push_back(percent(gone ? gone->removed_of_right : std::nullopt));
  return row;
}

// What all scenes and blocks say.
struct BlockTally {
  int judged = 0;
  int most_removed = 0;
  double lowest = 1;
  double highest = 0;

  void note(const Checked& both, const dataset::StereoScene& scene) {
    if (!scene.truth) {
      return;
    }
    const std::optional<double> share =
        removal(both.dense->disparity, both.checked->disparity, *scene.truth).removed_of_wrong;
    if (share) {
      ++judged;
      most_removed += *share > kMost ? 1 : 0;
      lowest = std::min(lowest, *share);
      highest = std::max(highest, *share);
    }
  }
};

std::vector<Figure> add_block_scene(Study& study, const Subject& subject, Table& table,
                                    BlockTally& tally) {
  const dataset::StereoScene& scene = subject.scene;
  std::vector<Figure> figures;
  table.rows.push_back({scene.name});
  for (const auto& [width, height] : {std::pair(16, 16), std::pair(30, 10), std::pair(60, 20)}) {
    const Checked both = match(study, scene, width, height);
    if (!both.dense || !both.checked) {
      continue;
    }
    const std::string name = std::to_string(width) + " × " + std::to_string(height);
    table.rows.push_back(table_row(name, both, scene));
    tally.note(both, scene);
    if (width == 16) {
      continue;
    }
    figures.push_back(map_figure(subject, both.checked->disparity,
                                 scene.name + ", " + name + ", checked",
                                 in_words(*both.checked) + "."));
    if (scene.truth && width == 60) {
      figures.push_back(figure(
          finding_picture(
              removed_pixels(both.dense->disparity, both.checked->disparity, *scene.truth),
              scene.left, std::nullopt),
          scene.name + ", what the check removed", "Block " + name + " px.", removal_legend()));
    }
  }
  return figures;
}

}  // namespace

void add_block_sizes(Study& study, Page& page) {
  page.begin_section("blocks", "Block sizes and the left-right check");
  page.paragraph(
      "The chapter's two blocks, 30 × 10 and 60 × 20 px, SAD on derivatives, winner takes all, "
      "with the left-right check: a match is kept when the match of the match is the pixel itself, "
      "within 1 px.");
  Table table{.caption = "With the check; shares in percent",
              .header = {"Block, px", "ms", "density", "bad of valid", "BP not occluded",
                         "wrong before", "of the wrong, removed", "of the right, removed"}};
  BlockTally tally;
  std::vector<std::vector<Figure>> figures;
  for (const Subject& subject : study.subjects()) {
    figures.push_back(add_block_scene(study, subject, table, tally));
  }
  page.table(table);
  page.claim({.chapter = "The left-right check removes most of the wrong matches.",
              .measured = tally.judged == 0
                              ? "No scene here has truth."
                              : "It removes between " + percent(tally.lowest, 0) + " and " +
                                    percent(tally.highest, 0) +
                                    " percent of the wrong disparities (occluded pixels "
                                    "included), by scene and block; more than half in " +
                                    std::to_string(tally.most_removed) + " of " +
                                    std::to_string(tally.judged) + " cases.",
              .rule = "yes: more than half of the wrong ones in every case; partly: in some.",
              .verdict = verdict_of(tally.most_removed, tally.judged)});
  for (const std::vector<Figure>& row : figures) {
    page.figures(row, Width::kMedium);
  }
}

}  // namespace stof::host
