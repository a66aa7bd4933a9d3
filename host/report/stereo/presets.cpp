// The presets.
#include "host/report/stereo/sections.h"

namespace stof::host {

void add_presets(Study& study, Page& page) {
  page.begin_section("presets", "Presets");
  page.paragraph("Parameter sets that need no tuning: the same for every scene. BP in percent.");
  Table table{.caption = "",
              .header = {"Preset", "ms", "density", "bad of valid", "BP not occluded", "BP all",
                         "near edges"}};
  std::vector<std::vector<Figure>> figures;  // of each scene
  for (const Subject& subject : study.subjects()) {
    const dataset::StereoScene& scene = subject.scene;
    figures.emplace_back();
    std::vector<std::vector<std::string>> rows;
    const auto add = [&](const std::string& name, const std::optional<Outcome>& outcome) {
      if (outcome) {
        const DisparityScore& score = outcome->score;
        rows.push_back({name, number(outcome->ms, 2), percent(score.density),
                        percent(score.of_valid), percent(score.visible), percent(score.all),
                        percent(score.near_edges)});
      }
    };
    for (const char* const name : {"fast", "quality", "chapter"}) {
      const std::optional<Outcome> outcome = study.run_preset(scene, name);
      add(name, outcome);
      if (outcome) {
        figures.back().push_back(map_figure(subject, outcome->disparity,
                                            scene.name + ", " + std::string(name),
                                            in_words(*outcome) + "."));
      }
    }
    add("quality, filled", study.run_preset(scene, "quality", true));
    if (!rows.empty()) {
      table.rows.push_back({scene.name});
      table.rows.insert(table.rows.end(), rows.begin(), rows.end());
    }
  }
  for (const char* const name : {"fast", "quality", "chapter"}) {
    if (const dsp::Preset* const found = dsp::find_preset(name); found != nullptr) {
      page.paragraph(std::string(name) + ": " + std::string(found->meaning));
    }
  }
  page.table(table);
  for (const std::vector<Figure>& row : figures) {
    page.figures(row, Width::kMedium);
  }
}

}  // namespace stof::host
