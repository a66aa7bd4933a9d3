#include "host/report/fusion/fusion_page.h"

#include <algorithm>

#include "host/report/fusion/fusion_figures.h"
#include "host/report/fusion/fusion_intervals.h"
#include "host/report/fusion/fusion_summary.h"

namespace stof::host {
namespace {

// Recordings of one pair by several PMD cameras stand together.
bool same_pair(const FusionCase& a, const FusionCase& b) {
  return a.scene == b.scene && a.left.pixels == b.left.pixels;
}

void add_fusion_scene(std::span<const FusionCase> cases, const FusionCase& first, int number,
                      Page& page) {
  page.begin_section("scene-" + std::to_string(number), first.scene);
  page.figures(stereo_figures(first), Width::kMedium);
  page.figures(stereo_height_fields(first), Width::kLarge);
  for (const FusionCase& fused : cases) {
    if (same_pair(fused, first)) {
      page.heading(first.scene + " with a PMD camera of " + fused.sensor() + " (" +
                   fused.recording + ")");
      page.figures(fused_figures(fused), Width::kMedium);
      page.figures(fused_height_fields(fused), Width::kLarge);
    }
  }
}

std::vector<std::string> lead(std::span<const FusionCase> cases, const std::string& matcher) {
  return {
      "Stereo pairs and PMD (time-of-flight) recordings with known depth, fused by the code of "
      "the stof appliance as in the 2006 book chapter of Kuhnert & Stommel: each sensor gives "
      "an interval of depth for a pixel, the result is their intersection.",
      "Matching: " + matcher + ". Pairs of scene and PMD camera: " + std::to_string(cases.size()) +
          ". E5 is the share of pixels with truth that are missing or off by more than 5 "
          "percent of the depth."};
}

}  // namespace

std::expected<void, dataset::Problem> write_fusion_page(std::span<const FusionCase> cases,
                                                        const std::string& matcher,
                                                        const std::filesystem::path& file) {
  Page page;
  add_fusion_summary(cases, page);
  add_fusion_intervals(cases, page);
  add_fusion_geometry(cases, page);
  int number = 0;
  for (std::size_t i = 0; i < cases.size(); ++i) {
    const std::span<const FusionCase> before = cases.first(i);
    if (std::ranges::none_of(before,
                             [&](const FusionCase& other) { return same_pair(other, cases[i]); })) {
      add_fusion_scene(cases, cases[i], ++number, page);
    }
  }
  return write_page(file, page.html("Stereo and PMD, fused", lead(cases, matcher)));
}

}  // namespace stof::host
