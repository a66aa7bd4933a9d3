#include "host/evaluate/fusion/fusion.h"

#include <algorithm>
#include <chrono>
#include <cmath>

#include "dataset/files/file.h"
#include "host/evaluate/fusion/chapter_geometry.h"
#include "host/evaluate/fusion/depth_images.h"
#include "host/evaluate/fusion/owning_depth_maker.h"
#include "host/evaluate/stereo/median.h"
#include "lab/match_options.h"

namespace stof::host {
namespace {

using Clock = std::chrono::steady_clock;

struct SplattedImages {
  dataset::Image<dsp::QuarterMm> nearest;
  dataset::Image<dsp::QuarterMm> low;
  dataset::Image<dsp::QuarterMm> high;
  dataset::Image<std::uint8_t> flags;

  SplattedImages(int w, int h) : nearest(w, h), low(w, h), high(w, h), flags(w, h) {}
  dsp::SplattedView view() { return {nearest.view(), low.view(), high.view(), flags.view()}; }
};

// Holes are never filled silently, and what was not checked is no measurement.
const char* why_not_fused(const MatchPlan& plan) {
  if (plan.annealing) {
    return "--method sa: an offline reference, not for fusion: use another";
  }
  if (plan.params.fill) {
    return "--fill: made-up disparities do not enter the fusion: leave it out";
  }
  if (!plan.params.left_right_tolerance) {
    return "--lr=off: only checked matches enter the fusion: leave it out";
  }
  return nullptr;
}

double ms_since(Clock::time_point begin) {
  return std::chrono::duration<double, std::milli>(Clock::now() - begin).count();
}

// One scene on its way through the appliance's objects.
struct Run {
  const dataset::StereoScene& scene;
  const dsp::PmdFrame& frame;
  dsp::DepthMaker& maker;
  std::int32_t pmd_lag_us;
  DepthImages images;

  void match() { maker.match(scene.left.view(), scene.right.view()); }
  DepthPlanes fuse() {
    maker.fuse(images.map(), pmd_lag_us);
    return images.planes();
  }
};

std::optional<PmdLoss> largest_loss(dsp::ImageView<const std::uint8_t> flags) {
  constexpr std::array<std::pair<dsp::PmdFlag, const char*>, 7> kCauses{
      {{dsp::kPmdSaturated, "saturated"},
       {dsp::kPmdUnderRange, "under range"},
       {dsp::kPmdLowAmplitude, "too dark"},
       {dsp::kPmdLowRatio, "hardly modulated"},
       {dsp::kPmdAsymmetric, "of moving things or changing light"},
       {dsp::kPmdOutOfRange, "beyond 16.38 m"},
       {dsp::kPmdWrapped, "of an unknown number of turns"}}};
  PmdLoss largest;
  const double pixels = static_cast<double>(flags.width()) * flags.height();
  for (const auto& [flag, cause] : kCauses) {
    std::size_t marked = 0;
    for (int y = 0; y < flags.height(); ++y) {
      marked += static_cast<std::size_t>(std::ranges::count_if(
          flags.row(y), [flag](std::uint8_t one) { return (one & flag) != 0; }));
    }
    if (const double share = static_cast<double>(marked) / pixels; share > largest.share) {
      largest = {.cause = cause, .share = share};
    }
  }
  return largest.share > 0 ? std::optional(largest) : std::nullopt;
}

// What the appliance does for every frame.
void fuse_both(Run& run, int runs, FusionResult& result) {
  std::vector<double> convert;
  std::vector<double> match;
  std::vector<double> fuse;
  for (int i = 0; i < std::max(runs, 1); ++i) {
    Clock::time_point begin = Clock::now();
    run.maker.convert(run.frame);
    convert.push_back(ms_since(begin));
    begin = Clock::now();
    run.match();
    match.push_back(ms_since(begin));
    begin = Clock::now();
    run.maker.fuse(run.images.map(), run.pmd_lag_us);
    fuse.push_back(ms_since(begin));
  }
  result.convert_ms = median(std::move(convert)).value_or(0);
  result.match_ms = median(std::move(match)).value_or(0);
  result.fuse_ms = median(std::move(fuse)).value_or(0);
  result.fused = run.images.planes();
  result.source = run.images.source;
  result.cause = run.images.cause;
}

// stereo: what the maker published of the pair alone; it holds the pair's and the PMD's maps.
ChapterPlanes with_less_effort(const dsp::DepthMaker& maker, const dsp::Calibration& calibration,
                               DepthImages& stereo, dsp::QuarterMm max_range) {
  const int width = stereo.depth.width;
  const int height = stereo.depth.height;
  SplattedImages splatted(width, height);
  DepthImages out(width, height);
  ChapterPlanes planes;
  const dsp::ImageView<const std::uint8_t> ratio = maker.stereo().ratio;
  splat_by_geometry(*maker.pmd(), calibration, splatted.view());
  fuse_by_interval(stereo.map(), ratio, splatted.view(), max_range, out.map());
  planes.reprojected = out.planes();
  splat_by_scaling(*maker.pmd(), calibration, splatted.view());
  fuse_by_interval(stereo.map(), ratio, splatted.view(), max_range, out.map());
  planes.fused = out.planes();
  fuse_by_interval(stereo.map(), {}, splatted.view(), max_range, out.map());
  planes.pmd = out.planes();
  return planes;
}

template <std::size_t kCount, typename Value>
std::array<std::size_t, kCount> count(const dataset::Image<Value>& image) {
  std::array<std::size_t, kCount> counts{};
  for (const Value value : image.pixels) {
    ++counts.at(static_cast<std::size_t>(value));
  }
  return counts;
}

}  // namespace

std::expected<lab::MatchParams, dataset::Problem> fusion_params(const MatchRequest& request,
                                                                int disparities) {
  MatchRequest asked = request;
  if (asked.preset.empty()) {
    asked.settings.insert(asked.settings.begin(), {"lr", "1"});
  }
  const std::expected<MatchPlan, dataset::Problem> plan = match_plan(asked, disparities);
  if (!plan) {
    return std::unexpected(plan.error());
  }
  if (const char* const why = why_not_fused(*plan)) {
    return dataset::refuse(why);
  }
  lab::MatchParams params = plan->params;
  if (!asked.preset.empty()) {
    params = lab::as_the_appliance(dsp::for_depth(*dsp::find_preset(asked.preset)));
    params.disparities = disparities;
    for (const auto& [name, value] : asked.settings) {
      lab::find_match_option(name)->set(value, params);
    }
  }
  params.confidence = true;
  if (const char* const why = lab::problem(params); *why != '\0') {
    return dataset::refuse(why);
  }
  return params;
}

dataset::Loaded<FusionResult> fuse_scene(const dataset::StereoScene& scene,
                                         const dataset::PmdRecording& recording,
                                         const lab::MatchParams& match,
                                         const FusionOptions& options) {
  const int width = scene.left.width;
  const int height = scene.left.height;
  dataset::Loaded<std::unique_ptr<OwningDepthMaker>> made = OwningDepthMaker::make(
      scene.name, recording.calibration, width, height, match,
      {.max_range = options.max_range, .guided = options.guided, .threads = options.threads});
  if (!made) {
    return std::unexpected(std::move(made.error()));
  }
  dsp::DepthMaker& maker = ***made;
  FusionResult result;
  if ((*made)->calibration().pmd.lens.width == 0) {
    DepthImages alone(width, height);
    maker.match(scene.left.view(), scene.right.view());
    maker.fuse(alone.map());
    result.stereo = alone.planes();
    return result;
  }
  const FirstFrame first(recording);
  Run run{.scene = scene,
          .frame = first.frame(),
          .maker = maker,
          .pmd_lag_us = recording.after_pair_us,
          .images = DepthImages(width, height)};
  maker.convert(run.frame);
  result.pmd_loss = largest_loss(maker.pmd()->flags);
  result.pmd = run.fuse();
  maker.forget_pmd();
  run.match();
  result.stereo = run.fuse();
  DepthImages stereo = run.images;
  fuse_both(run, options.runs, result);
  if (options.chapter_geometry) {
    result.chapter = with_less_effort(maker, (*made)->calibration(), stereo, options.max_range);
  }
  return result;
}

std::array<std::size_t, dsp::kSources> count_sources(const dataset::Image<dsp::Source>& source) {
  return count<dsp::kSources>(source);
}

std::array<std::size_t, dsp::kCauses> count_causes(const dataset::Image<dsp::Cause>& cause) {
  return count<dsp::kCauses>(cause);
}

namespace {

SourceScores score_sources(const FusionResult& result, const dataset::Image<float>& truth) {
  struct Count {
    std::size_t all = 0;
    std::size_t off = 0;
    std::size_t hits = 0;
    std::size_t collisions = 0;
  };
  std::array<Count, dsp::kSources> counts{};
  std::size_t known = 0;
  for (std::size_t i = 0; i < truth.pixels.size(); ++i) {
    const double z = truth.pixels[i];
    known += std::isfinite(z) ? 1U : 0U;
    const double depth = result.fused.depth.pixels[i];
    if (!std::isfinite(z) || !std::isfinite(depth)) {
      continue;
    }
    Count& count = counts.at(static_cast<std::size_t>(result.source.pixels[i]));
    const double low = result.fused.low.pixels[i];
    const double high = result.fused.high.pixels[i];
    ++count.all;
    count.off += std::abs(depth - z) > kLargestRelativeError * z ? 1U : 0U;
    count.hits += low <= z && z <= high ? 1U : 0U;
    count.collisions += depth - z > kCollisionM ? 1U : 0U;
  }
  const auto share = [](std::size_t part, std::size_t whole) {
    return whole == 0 ? std::nullopt
                      : std::optional(static_cast<double>(part) / static_cast<double>(whole));
  };
  SourceScores scores;
  for (std::size_t k = 0; k < scores.size(); ++k) {
    scores[k] = {.share = share(counts[k].all, known).value_or(0),
                 .off = share(counts[k].off, counts[k].all),
                 .hit_rate = share(counts[k].hits, counts[k].all),
                 .collisions = share(counts[k].collisions, counts[k].all)};
  }
  return scores;
}

SourceScore mean_source(std::span<const FusionScores> scores, std::size_t source) {
  SourceScore mean;
  double off = 0;
  double hits = 0;
  double collisions = 0;
  for (const FusionScores& each : scores) {
    const SourceScore& score = each.by_source[source];
    mean.share += score.share;
    off += score.share * score.off.value_or(0);
    hits += score.share * score.hit_rate.value_or(0);
    collisions += score.share * score.collisions.value_or(0);
  }
  if (mean.share > 0) {
    mean.off = off / mean.share;
    mean.hit_rate = hits / mean.share;
    mean.collisions = collisions / mean.share;
    mean.share /= static_cast<double>(scores.size());
  }
  return mean;
}

}  // namespace

FusionScores score_fusion(const FusionResult& result, const dataset::Image<float>& truth) {
  FusionScores scores{.pmd = score_depth(result.pmd, truth),
                      .stereo = score_depth(result.stereo, truth),
                      .fused = score_depth(result.fused, truth),
                      .by_source = score_sources(result, truth),
                      .chapter_pmd = std::nullopt,
                      .chapter_fused = std::nullopt,
                      .reprojected = std::nullopt};
  if (result.chapter) {
    scores.chapter_pmd = score_depth(result.chapter->pmd, truth);
    scores.chapter_fused = score_depth(result.chapter->fused, truth);
    scores.reprojected = score_depth(result.chapter->reprojected, truth);
  }
  return scores;
}

FusionScores mean_scores(std::span<const FusionScores> scores) {
  const auto mean = [scores](auto part) {
    std::vector<DepthScore> parts;
    for (const FusionScores& each : scores) {
      if (const std::optional<DepthScore> score = each.*part) {
        parts.push_back(*score);
      }
    }
    return parts;
  };
  const auto optional_mean = [&mean](auto part) {
    const std::vector<DepthScore> parts = mean(part);
    return parts.empty() ? std::nullopt : std::optional(mean_score(parts));
  };
  SourceScores by_source;
  for (std::size_t k = 0; k < by_source.size(); ++k) {
    by_source[k] = mean_source(scores, k);
  }
  return {.pmd = mean_score(mean(&FusionScores::pmd)),
          .stereo = mean_score(mean(&FusionScores::stereo)),
          .fused = mean_score(mean(&FusionScores::fused)),
          .by_source = by_source,
          .chapter_pmd = optional_mean(&FusionScores::chapter_pmd),
          .chapter_fused = optional_mean(&FusionScores::chapter_fused),
          .reprojected = optional_mean(&FusionScores::reprojected)};
}

}  // namespace stof::host
