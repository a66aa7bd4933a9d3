// The scenes and their maps.
#include "host/report/stereo/sections.h"

namespace stof::host {

void add_scenes(Study& study, Page& page) {
  page.begin_section("scenes", "Scenes and measures");
  Table table{.caption = "Disparities in px of the left picture",
              .header = {"Scene", "size, px", "candidates", "truth from", "to", "% with truth",
                         "% not occluded"}};
  for (const Subject& subject : study.subjects()) {
    const dataset::StereoScene& scene = subject.scene;
    int known = 0;
    int visible = 0;
    for (std::size_t i = 0; i < scene.left.pixels.size(); ++i) {
      const bool has_truth = scene.truth && scene.truth->pixels[i] < 1e6F;
      known += has_truth ? 1 : 0;
      visible += has_truth && scene.visible && scene.visible->pixels[i] != 0 ? 1 : 0;
    }
    const double pixels = static_cast<double>(scene.left.pixels.size());
    const auto limit = [&](double px) { return scene.truth ? number(px, 0) : "–"; };
    table.rows.push_back(
        {scene.name, std::to_string(scene.left.width) + " × " + std::to_string(scene.left.height),
         std::to_string(scene.ndisp), limit(subject.scale.far_px), limit(subject.scale.near_px),
         scene.truth ? percent(known / pixels) : "–",
         scene.visible ? percent(visible / pixels) : "–"});
  }
  page.table(table);
  page.paragraph(
      "A pixel is bad when its disparity is missing or off by more than 1 px. Four readings of the "
      "chapter's equation 5: over all pixels that have truth, or over those that both cameras see "
      "(not occluded); with the absolute value that the equation must mean, or signed as printed, "
      "where only what is too near counts. Density is the share of all pixels that have a "
      "disparity. Times are medians of " +
      std::to_string(study.runs()) + " runs on one thread.");
}

void add_maps(Study& study, Page& page) {
  page.begin_section("maps", "Maps and 2.5D views");
  page.paragraph(
      "For every scene the colours stand for the same disparities throughout this page: warm is "
      "near, cold is far, the checker is no disparity. In difference maps the left picture shines "
      "through where the map is right. In 2.5D views the height is the disparity; for display "
      "alone steps of up to 1.25 px are smoothed and the surface is cut where neighbours differ by "
      "more than 2 px; the grey plate shows where there is no disparity.");
  for (const Subject& subject : study.subjects()) {
    const dataset::StereoScene& scene = subject.scene;
    page.heading(scene.name);
    std::vector<Figure> flat{figure(
        scene.left, scene.name + ", left picture",
        std::to_string(scene.left.width) + " × " + std::to_string(scene.left.height) + " px.")};
    std::vector<Figure> views;
    const auto add = [&](const std::string& title, const std::optional<Outcome>& outcome) {
      if (!outcome) {
        return;
      }
      study.note(scene.name, title, *outcome);
      flat.push_back(map_figure(subject, outcome->disparity, title, in_words(*outcome) + "."));
      if (scene.truth) {
        flat.push_back(difference_figure(
            subject, outcome->disparity, title + ", differences",
            scene.visible ? "Against the truth; paler where occluded." : "Against the truth."));
      }
    };
    const std::optional<Outcome> chapter =
        study.run(scene, {"WTA SAD 16 × 16", block_match(scene, lab::Cost::kSad, 16, 16, true)});
    add("SAD 16 × 16, winner takes all", chapter);
    if (scene.truth) {
      flat.push_back(map_figure(subject, *scene.truth, "Truth", "Disparity in px."));
    }
    const std::optional<Outcome> filled = study.run_preset(scene, "quality", true);
    add("Preset quality, filled", filled);
    const std::optional<Outcome>& best = filled ? filled : chapter;
    if (best) {
      views.push_back(height_field_figure(subject, best->disparity, "2.5D view, computed",
                                          filled ? "Preset quality, filled." : "SAD 16 × 16.",
                                          study.quick()));
    }
    if (scene.truth) {
      views.push_back(height_field_figure(subject, *scene.truth, "2.5D view of the truth",
                                          "The same point of view.", study.quick()));
    }
    page.figures(flat, Width::kMedium);
    page.figures(views, Width::kLarge);
  }
}

}  // namespace stof::host
