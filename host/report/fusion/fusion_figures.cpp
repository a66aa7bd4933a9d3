#include "host/report/fusion/fusion_figures.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "host/evaluate/stereo/median.h"
#include "host/picture/disparity_picture.h"
#include "host/picture/height_field.h"
#include "host/picture/source_colours.h"
#include "host/report/page/legend.h"

namespace stof::host {
namespace {

constexpr int kHeightFieldWidth = 560;

struct Swatch {
  Rgb colour;
  const char* meaning;
};
constexpr Rgb kNoColour = kSourceColours[0];
constexpr std::array<Swatch, dsp::kSources> kSourceSwatches{
    {{kNoColour, "none"},
     {kSourceColours[1], "stereo alone"},
     {kSourceColours[2], "PMD alone"},
     {kSourceColours[3], "both agree"},
     {kSourceColours[4], "resolved: the better supported sensor"},
     {kSourceColours[5], "conflict: no depth"}}};
constexpr std::array<Swatch, dsp::kCauses> kCauseSwatches{{{kNoColour, kCauseMeanings[0]},
                                                           {{150, 96, 190}, kCauseMeanings[1]},
                                                           {{238, 155, 40}, kCauseMeanings[2]},
                                                           {{20, 150, 170}, kCauseMeanings[3]},
                                                           {{66, 133, 200}, kCauseMeanings[4]},
                                                           {{206, 44, 52}, kCauseMeanings[5]},
                                                           {{196, 190, 90}, kCauseMeanings[6]}}};

template <std::size_t kCount>
std::string swatches(const std::array<Swatch, kCount>& all, std::size_t first) {
  std::vector<std::pair<Rgb, std::string>> entries;
  for (std::size_t i = first; i < kCount; ++i) {
    entries.emplace_back(all[i].colour, all[i].meaning);
  }
  return colour_legend(entries);
}

// Where it lies on the side of what is not `right`.
Finding side(bool right, bool too_near) {
  if (right) {
    return Finding::kRight;
  }
  return too_near ? Finding::kTooNear : Finding::kTooFar;
}

template <typename Judge>
dataset::Image<Finding> findings(const DepthPlanes& planes, const dataset::Image<float>& truth,
                                 Judge judge) {
  dataset::Image<Finding> result(truth.width, truth.height);
  for (std::size_t i = 0; i < truth.pixels.size(); ++i) {
    if (!std::isfinite(truth.pixels[i])) {
      result.pixels[i] = Finding::kUnknown;
    } else if (!std::isfinite(planes.depth.pixels[i])) {
      result.pixels[i] = Finding::kMissing;
    } else {
      result.pixels[i] = judge(i, static_cast<double>(truth.pixels[i]));
    }
  }
  return result;
}

Figure depth_figure(const FusionCase& fused, const dataset::Image<float>& depth, std::string title,
                    std::string caption) {
  const ColourScale scale = scales_of(fused).depth;
  return figure(metric_picture(depth, scale), std::move(title), std::move(caption),
                depth_legend(scale));
}

// ", 1.65 to 2.90 in colours"
std::string range_text(const FusionCase& fused) {
  const ColourScale scale = scales_of(fused).depth;
  return ", " + number(scale.near_m, 2) + " to " + number(scale.far_m, 2) + " in colours";
}

std::string in_words(const DepthScore& score) {
  return "E5 " + percent(score.e5) + " %, " + percent(score.coverage) + " % covered.";
}

Figure error_figure(const FusionCase& fused, const DepthPlanes& planes, const DepthScore& score,
                    std::string title) {
  const dataset::Image<Finding> errors =
      findings(planes, fused.truth, [&planes](std::size_t i, double z) {
        const double error = planes.depth.pixels[i] - z;
        return side(std::abs(error) <= kLargestRelativeError * z, error < 0);
      });
  return figure(finding_picture(errors, fused.left, {}), std::move(title),
                "Right: within 5 percent. " + in_words(score), difference_legend());
}

Figure hit_figure(const FusionCase& fused) {
  const DepthPlanes& planes = fused.result.fused;
  const dataset::Image<Finding> hits =
      findings(planes, fused.truth, [&planes](std::size_t i, double z) {
        return side(planes.low.pixels[i] <= z && z <= planes.high.pixels[i],
                    planes.high.pixels[i] < z);
      });
  const std::string legend = finding_legend({{Finding::kRight, "holds the truth"},
                                             {Finding::kTooNear, "too near"},
                                             {Finding::kTooFar, "too far"},
                                             {Finding::kMissing, "none"},
                                             {Finding::kUnknown, "no truth"}});
  return figure(finding_picture(hits, fused.left, {}), "Published interval",
                "Where it holds the truth: " + percent(fused.scores.fused.hit_rate) +
                    " % of what is covered; median width " +
                    percent(fused.scores.fused.median_width_relative) + " % of the depth.",
                legend);
}

Figure source_figure(const FusionCase& fused) {
  dataset::Image<Rgb> picture(fused.left.width, fused.left.height);
  for (int y = 0; y < picture.height; ++y) {
    for (int x = 0; x < picture.width; ++x) {
      const dsp::Source source = fused.result.source.view().at(x, y);
      picture.view().at(x, y) = source == dsp::Source::kNone
                                    ? none_colour(x, y)
                                    : kSourceSwatches.at(static_cast<std::size_t>(source)).colour;
    }
  }
  return figure(picture, "Source of the depth", "Which sensor each depth comes from.",
                swatches(kSourceSwatches, 1));
}

Figure cause_figure(const FusionCase& fused) {
  dataset::Image<Rgb> picture = as_colour(fused.left, true);
  for (std::size_t i = 0; i < picture.pixels.size(); ++i) {
    const dsp::Cause cause = fused.result.cause.pixels[i];
    if (cause != dsp::Cause::kNone) {
      picture.pixels[i] = kCauseSwatches.at(static_cast<std::size_t>(cause)).colour;
    }
  }
  return figure(picture, "Cause", "Why a depth was resolved, or why there is none.",
                swatches(kCauseSwatches, 1));
}

// Heights of a height field: d = f b / Z - doff.
dataset::Image<float> to_disparity(const dataset::Image<float>& depth, const dsp::StereoRig& rig) {
  dataset::Image<float> disparity(depth.width, depth.height, kNoDisparity);
  for (std::size_t i = 0; i < depth.pixels.size(); ++i) {
    const double z = depth.pixels[i];
    if (std::isfinite(z) && z > 0) {
      disparity.pixels[i] = static_cast<float>(rig.left.fx * rig.baseline_m / z - rig.doff_px);
    }
  }
  return disparity;
}

Figure height_field_of(const FusionCase& fused, const dataset::Image<float>& depth,
                       std::string title, std::string caption) {
  const DisparityScale scale = scales_of(fused).disparity;
  HeightFieldView view;
  view.width = kHeightFieldWidth;
  return figure(
      height_field_picture(to_disparity(depth, fused.rig), to_disparity(fused.truth, fused.rig),
                           scale.far_px, scale.near_px, fused.left, view),
      std::move(title), std::move(caption));
}

}  // namespace

FusionScales scales_of(const FusionCase& fused) {
  std::vector<double> known;
  std::ranges::copy_if(fused.truth.pixels, std::back_inserter(known),
                       [](float z) { return std::isfinite(z); });
  constexpr double kOutliers = 0.002;
  constexpr double kWider = 1.03;
  const double near = percentile(known, kOutliers).value_or(1) / kWider;
  const double far = percentile(known, 1 - kOutliers).value_or(2) * kWider;
  const double reach = fused.rig.left.fx * fused.rig.baseline_m;
  return {.depth = {.near_m = near, .far_m = far},
          .disparity = {.far_px = reach / far - fused.rig.doff_px,
                        .near_px = reach / near - fused.rig.doff_px}};
}

std::vector<Figure> stereo_figures(const FusionCase& fused) {
  const FusionResult& result = fused.result;
  return {
      figure(fused.left, "Left picture",
             std::to_string(fused.left.width) + " × " + std::to_string(fused.left.height) + " px."),
      depth_figure(fused, fused.truth, "True depth", "Z in metres" + range_text(fused) + "."),
      depth_figure(fused, result.stereo.depth, "Stereo alone",
                   "Checked from both sides, nothing filled."),
      error_figure(fused, result.stereo, fused.scores.stereo, "Stereo alone, errors")};
}

std::vector<Figure> fused_figures(const FusionCase& fused) {
  const FusionResult& result = fused.result;
  return {depth_figure(fused, result.pmd.depth, "PMD alone", "Carried into the left picture."),
          error_figure(fused, result.pmd, fused.scores.pmd, "PMD alone, errors"),
          depth_figure(fused, result.fused.depth, "Fused", "Z in metres" + range_text(fused) + "."),
          error_figure(fused, result.fused, fused.scores.fused, "Fused, errors"),
          source_figure(fused),
          cause_figure(fused),
          hit_figure(fused)};
}

std::vector<Figure> stereo_height_fields(const FusionCase& fused) {
  return {height_field_of(fused, fused.truth, "2.5D view of the truth",
                          "The same point of view for all."),
          height_field_of(fused, fused.result.stereo.depth, "2.5D view, stereo alone",
                          "The grey plate shows where there is no depth.")};
}

std::vector<Figure> fused_height_fields(const FusionCase& fused) {
  return {height_field_of(fused, fused.result.pmd.depth, "2.5D view, PMD alone",
                          "As large as its pixels are in the left picture."),
          height_field_of(fused, fused.result.fused.depth, "2.5D view, fused",
                          "Nothing is filled: the plate shows where there is no depth.")};
}

}  // namespace stof::host
