// Histogram and subpixel filters: were the pixels wrong that they remove?
#include <array>

#include "host/report/page/legend.h"
#include "host/report/stereo/sections.h"
#include "host/text/printed.h"

namespace stof::host {
namespace {

constexpr double kMostly = 0.5;
constexpr int kHistogramPermille = 4;  // "a few tenths of a percent"

struct Filter {
  const char* title;
  const char* name;
  void (*switch_on)(lab::MatchParams& params);
};
constexpr std::array<Filter, 2> kFilters{
    {{"Histogram", "histogram, below 0.4 % of the picture",
      [](lab::MatchParams& params) { params.histogram_permille = kHistogramPermille; }},
     {"|s| > 1/2", "least-squares subpixel, |s| > 1/2",
      [](lab::MatchParams& params) { params.subpixel = dsp::Subpixel::kLeastSquares; }}}};

// What all scenes say, filter by filter.
struct FilterTally {
  int judged = 0;
  int mostly_wrong = 0;
  std::array<std::string, kFilters.size()> lists;

  void note(const std::string& scene, std::size_t filter, const Removal& gone) {
    if (!gone.wrong_of_removed) {
      return;
    }
    ++judged;
    mostly_wrong += *gone.wrong_of_removed > kMostly ? 1 : 0;
    std::string& list = lists[filter];
    add_to(list, scene + " " + percent(gone.wrong_of_removed, 0));
  }
  std::string text() const {
    std::string all;
    for (std::size_t i = 0; i < kFilters.size(); ++i) {
      all += lists[i].empty() ? "" : " " + std::string(kFilters[i].title) + ": " + lists[i] + ".";
    }
    return all.empty() ? "Nothing was removed where there is truth."
                       : "Wrong among the removed, in percent." + all;
  }
};

}  // namespace

void add_filters(Study& study, Page& page) {
  page.begin_section("filters", "Histogram and subpixel filters");
  page.paragraph(
      "Both work on the checked map (SAD 16 × 16 on derivatives, left-right check). The histogram "
      "filter drops disparities that only a few pixels share. The least-squares fit shifts each "
      "match by a fraction s of a pixel; a shift of more than half a pixel says that the match was "
      "wrong, and it is dropped. Right matches that lie midway between two whole disparities have "
      "|s| near 1/2 by nature, and many of them go too: the stripes.");
  Table table{.caption = "Pixels with truth; shares in percent",
              .header = {"Filter", "removed", "of them wrong", "of the wrong, removed",
                         "of the right, removed", "wrong before", "wrong after"}};
  FilterTally tally;
  std::vector<Figure> figures;
  for (const Subject& subject : study.subjects()) {
    const dataset::StereoScene& scene = subject.scene;
    if (!scene.truth) {
      continue;
    }
    lab::MatchParams params = block_match(scene, lab::Cost::kSad, 16, 16, true);
    params.left_right_tolerance = 1;
    const std::optional<Outcome> before = study.run(scene, {"SAD 16 × 16, checked", params});
    table.rows.push_back({scene.name});
    for (std::size_t i = 0; i < kFilters.size(); ++i) {
      const Filter& filter = kFilters[i];
      lab::MatchParams with = params;
      filter.switch_on(with);
      const std::optional<Outcome> after = study.run(scene, {filter.name, with});
      if (!before || !after) {
        continue;
      }
      const Removal gone = removal(before->disparity, after->disparity, *scene.truth);
      table.rows.push_back({filter.name, percent(gone.removed, 2), percent(gone.wrong_of_removed),
                            percent(gone.removed_of_wrong), percent(gone.removed_of_right),
                            percent(gone.wrong_before, 2), percent(gone.wrong_after, 2)});
      tally.note(scene.name, i, gone);
      figures.push_back(
          figure(finding_picture(removed_pixels(before->disparity, after->disparity, *scene.truth),
                                 scene.left, std::nullopt),
                 scene.name + ", " + std::string(filter.name),
                 percent(gone.removed, 2) + " % removed, " + percent(gone.wrong_of_removed) +
                     " % of them wrong.",
                 removal_legend()));
    }
  }
  page.table(table);
  page.claim({.chapter =
                  "What the histogram filter and the rejection of |s| > 1/2 remove is mostly "
                  "wrong.",
              .measured = tally.text(),
              .rule = "yes: more than half of the removed pixels were wrong, every filter and "
                      "scene; partly: in some.",
              .verdict = verdict_of(tally.mostly_wrong, tally.judged)});
  page.figures(figures, Width::kSmall);
}

}  // namespace stof::host
