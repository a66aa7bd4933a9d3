#include "host/report/stereo/study.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "host/evaluate/stereo/match.h"
#include "host/picture/height_field.h"
#include "host/report/page/legend.h"
#include "host/text/printed.h"

namespace stof::host {
namespace {

constexpr float kWrongAbovePx = 1;

DisparityScale scale_of(const dataset::StereoScene& scene) {
  float low = std::numeric_limits<float>::infinity();
  float high = -std::numeric_limits<float>::infinity();
  if (scene.truth) {
    for (const float d : scene.truth->pixels) {
      if (std::isfinite(d)) {
        low = std::min(low, d);
        high = std::max(high, d);
      }
    }
  }
  if (!(low <= high)) {
    return {.far_px = 0, .near_px = scene.ndisp > 1 ? scene.ndisp - 1.0 : 1.0};
  }
  const double far_px = std::floor(low);
  return {.far_px = far_px, .near_px = std::max<double>(std::ceil(high), far_px + 1)};
}

// 1 where the mask says occluded, or unknown.
std::optional<dataset::Image<std::uint8_t>> occluded(const dataset::StereoScene& scene) {
  if (!scene.visible) {
    return std::nullopt;
  }
  dataset::Image<std::uint8_t> mask(scene.left.width, scene.left.height);
  std::ranges::transform(scene.visible->pixels, mask.pixels.begin(),
                         [](std::uint8_t visible) { return visible == 0 ? 1 : 0; });
  return mask;
}

}  // namespace

Subject::Subject(dataset::StereoScene loaded) : scene(std::move(loaded)), scale(scale_of(scene)) {}

std::optional<Outcome> Study::run(const dataset::StereoScene& scene, const Experiment& experiment) {
  const MatchPlan plan{
      .params = experiment.params, .annealing = experiment.annealing, .runs = runs_};
  const dataset::Loaded<MatchResult> result = match_scene(scene, plan);
  if (!result) {
    refused_.insert(experiment.name);
    return std::nullopt;
  }
  Outcome outcome;
  outcome.disparity = to_pixels(result->disparity.view());
  outcome.ms = result->median_ms;
  const auto made_up =
      std::ranges::count_if(result->filled.pixels, [](std::uint8_t filled) { return filled != 0; });
  outcome.filled = static_cast<double>(made_up) /
                   static_cast<double>(std::max<std::size_t>(outcome.disparity.pixels.size(), 1));
  outcome.score = score_disparity(outcome.disparity, scene, experiment.params.block_width);
  return outcome;
}

std::optional<Outcome> Study::run_preset(const dataset::StereoScene& scene, std::string_view name,
                                         bool fill) {
  const std::string title = "preset " + std::string(name);
  std::optional<lab::MatchParams> params = preset(scene, name);
  if (!params) {
    refused_.insert(title);
    return std::nullopt;
  }
  params->fill = params->fill || fill;
  return run(scene, {title, *params});
}

void Study::note(const std::string& scene, const std::string& method, const Outcome& outcome) {
  const auto padded = [](const std::string& text, int columns) {
    // Bytes of UTF-8 that begin a character.
    const auto taken = std::ranges::count_if(
        text, [](char c) { return (static_cast<unsigned char>(c) & 0xC0U) != 0x80U; });
    return text +
           std::string(static_cast<std::size_t>(std::max<std::ptrdiff_t>(columns - taken, 1)), ' ');
  };
  notes_ += padded(scene, 14) + padded(method, 32) + in_words(outcome) + "\n";
}

lab::MatchParams block_match(const dataset::StereoScene& scene, lab::Cost cost, int block_width,
                             int block_height, bool derivative) {
  lab::MatchParams params;
  params.disparities = scene.ndisp;
  params.cost = cost;
  params.block_width = block_width;
  params.block_height = block_height;
  if (!derivative) {
    params.prefilter_cap = std::nullopt;
  }
  return params;
}

std::optional<lab::MatchParams> preset(const dataset::StereoScene& scene, std::string_view name) {
  const dsp::Preset* const found = dsp::find_preset(name);
  if (found == nullptr) {
    return std::nullopt;
  }
  lab::MatchParams params = lab::as_the_appliance(found->params);
  params.disparities = scene.ndisp;
  return params;
}

Removal removal(const dataset::Image<float>& before, const dataset::Image<float>& after,
                const dataset::Image<float>& truth) {
  int right = 0;
  int wrong = 0;
  int right_removed = 0;
  int wrong_removed = 0;
  for (std::size_t i = 0; i < truth.pixels.size(); ++i) {
    if (!std::isfinite(truth.pixels[i]) || !std::isfinite(before.pixels[i])) {
      continue;
    }
    const bool is_wrong = std::abs(before.pixels[i] - truth.pixels[i]) > kWrongAbovePx;
    const int is_removed = std::isfinite(after.pixels[i]) ? 0 : 1;
    (is_wrong ? wrong : right) += 1;
    (is_wrong ? wrong_removed : right_removed) += is_removed;
  }
  const int removed = right_removed + wrong_removed;
  return {.removed = share(removed, right + wrong).value_or(0),
          .wrong_of_removed = share(wrong_removed, removed),
          .removed_of_wrong = share(wrong_removed, wrong),
          .removed_of_right = share(right_removed, right),
          .wrong_before = share(wrong, right + wrong),
          .wrong_after = share(wrong - wrong_removed, right + wrong - removed)};
}

dataset::Image<Finding> removed_pixels(const dataset::Image<float>& before,
                                       const dataset::Image<float>& after,
                                       const dataset::Image<float>& truth) {
  dataset::Image<Finding> findings(before.width, before.height, Finding::kRight);
  for (std::size_t i = 0; i < findings.pixels.size(); ++i) {
    const bool was = std::isfinite(before.pixels[i]);
    const bool is = std::isfinite(after.pixels[i]);
    if (!was) {
      findings.pixels[i] = Finding::kMissing;
    } else if (!is && !std::isfinite(truth.pixels[i])) {
      findings.pixels[i] = Finding::kUnknown;
    } else if (!is) {
      findings.pixels[i] = std::abs(before.pixels[i] - truth.pixels[i]) > kWrongAbovePx
                               ? Finding::kRightlyRemoved
                               : Finding::kWronglyRemoved;
    }
  }
  return findings;
}

Figure map_figure(const Subject& subject, const dataset::Image<float>& disparity, std::string title,
                  std::string caption) {
  return figure(disparity_picture(disparity, subject.scale), std::move(title), std::move(caption),
                disparity_legend(subject.scale));
}

Figure difference_figure(const Subject& subject, const dataset::Image<float>& disparity,
                         std::string title, std::string caption) {
  return figure(finding_picture(differences(disparity, *subject.scene.truth), subject.scene.left,
                                occluded(subject.scene)),
                std::move(title), std::move(caption), difference_legend());
}

Figure height_field_figure(const Subject& subject, const dataset::Image<float>& disparity,
                           std::string title, std::string caption, bool quick) {
  constexpr int kQuickWidth = 120;
  HeightFieldView view;
  if (quick) {
    view.width = kQuickWidth;
  }
  return figure(
      height_field_picture(disparity, subject.scene.truth.value_or(disparity), subject.scale.far_px,
                           subject.scale.near_px, subject.scene.left, view),
      std::move(title), std::move(caption));
}

std::string in_words(const Outcome& outcome) {
  std::string text;
  if (outcome.score.visible) {
    add_to(text, percent(outcome.score.visible) + " % bad not occluded");
  }
  if (outcome.score.all) {
    add_to(text, percent(outcome.score.all) + " % bad of all");
  }
  add_to(text, percent(outcome.score.density) + " % dense" +
                   (outcome.filled > 0 ? " (" + percent(outcome.filled) + " % filled)" : ""));
  add_to(text, number(outcome.ms, 1) + " ms");
  return text;
}

std::optional<double> headline(const DisparityScore& score) {
  return score.visible ? score.visible : score.all;
}

}  // namespace stof::host
