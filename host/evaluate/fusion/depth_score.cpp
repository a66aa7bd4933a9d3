#include "host/evaluate/fusion/depth_score.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "host/evaluate/mean_of.h"
#include "host/evaluate/stereo/median.h"

namespace stof::host {
namespace {

constexpr float kNone = std::numeric_limits<float>::infinity();

bool contains(double low, double z, double high) { return low <= z && z <= high; }

}  // namespace

DepthScore score_depth(const DepthPlanes& planes, const dataset::Image<float>& truth) {
  DepthScore score;
  std::vector<double> errors;
  std::vector<double> relative;
  std::vector<double> widths;
  std::vector<double> relative_widths;
  std::size_t bad = 0;
  std::size_t collisions = 0;
  for (std::size_t i = 0; i < truth.pixels.size(); ++i) {
    const double z = static_cast<double>(truth.pixels[i]);
    if (!std::isfinite(z)) {
      continue;
    }
    ++score.truth_pixels;
    const double depth = static_cast<double>(planes.depth.pixels[i]);
    if (!std::isfinite(depth)) {
      ++bad;
      continue;
    }
    const double error = std::abs(depth - z);
    const double low = static_cast<double>(planes.low.pixels[i]);
    const double high = static_cast<double>(planes.high.pixels[i]);
    bad += error > kLargestRelativeError * z ? 1U : 0U;
    collisions += depth - z > kCollisionM ? 1U : 0U;
    errors.push_back(error);
    relative.push_back(error / z);
    widths.push_back(high - low);
    relative_widths.push_back((high - low) / z);
  }
  if (score.truth_pixels > 0) {
    score.e5 = static_cast<double>(bad) / static_cast<double>(score.truth_pixels);
    score.coverage = static_cast<double>(errors.size()) / static_cast<double>(score.truth_pixels);
  }
  if (!errors.empty()) {
    score.collisions = static_cast<double>(collisions) / static_cast<double>(errors.size());
  }
  const std::vector<IntervalCheck> checks = check_intervals(planes, truth);
  score.hit_rate = hit_rates_by_width(checks, 1).front();
  std::ranges::copy(hit_rates_by_width(checks, kWidthParts), score.hit_rate_by_width.begin());
  score.median_error_m = median(std::move(errors));
  score.median_relative = median(std::move(relative));
  score.median_width_m = median(std::move(widths));
  score.median_width_relative = median(std::move(relative_widths));
  return score;
}

DepthScore mean_score(std::span<const DepthScore> scores) {
  DepthScore mean;
  for (const DepthScore& score : scores) {
    mean.truth_pixels += score.truth_pixels;
  }
  mean.e5 = mean_of(scores, &DepthScore::e5).value_or(1);
  mean.coverage = mean_of(scores, &DepthScore::coverage).value_or(0);
  mean.median_error_m = mean_of(scores, &DepthScore::median_error_m);
  mean.median_relative = mean_of(scores, &DepthScore::median_relative);
  mean.hit_rate = mean_of(scores, &DepthScore::hit_rate);
  mean.collisions = mean_of(scores, &DepthScore::collisions);
  mean.median_width_m = mean_of(scores, &DepthScore::median_width_m);
  mean.median_width_relative = mean_of(scores, &DepthScore::median_width_relative);
  for (std::size_t k = 0; k < mean.hit_rate_by_width.size(); ++k) {
    mean.hit_rate_by_width[k] =
        mean_of(scores, [k](const DepthScore& s) { return s.hit_rate_by_width[k]; });
  }
  return mean;
}

std::vector<IntervalCheck> check_intervals(const DepthPlanes& planes,
                                           const dataset::Image<float>& truth) {
  std::vector<IntervalCheck> checks;
  for (std::size_t i = 0; i < truth.pixels.size(); ++i) {
    if (std::isfinite(truth.pixels[i]) && std::isfinite(planes.depth.pixels[i])) {
      const double low = planes.low.pixels[i];
      const double high = planes.high.pixels[i];
      checks.push_back({.width_m = high - low, .hit = contains(low, truth.pixels[i], high)});
    }
  }
  return checks;
}

std::vector<std::optional<double>> hit_rates_by_width(std::span<const IntervalCheck> checks,
                                                      int parts) {
  std::vector<std::size_t> order;
  order.reserve(checks.size());
  for (std::size_t i = 0; i < checks.size(); ++i) {
    order.push_back(i);
  }
  std::ranges::sort(order, {}, [checks](std::size_t i) { return std::pair(checks[i].width_m, i); });
  std::vector<std::optional<double>> rates;
  const std::size_t whole = static_cast<std::size_t>(parts);
  for (std::size_t part = 0; part < whole; ++part) {
    const std::size_t begin = order.size() * part / whole;
    const std::size_t end = order.size() * (part + 1) / whole;
    const auto hits = std::ranges::count(std::span(order).subspan(begin, end - begin), true,
                                         [checks](std::size_t i) { return checks[i].hit; });
    rates.push_back(
        begin == end ? std::nullopt
                     : std::optional(static_cast<double>(hits) / static_cast<double>(end - begin)));
  }
  return rates;
}

DepthPlanes to_metres(dsp::ImageView<const dsp::QuarterMm> depth,
                      dsp::ImageView<const dsp::QuarterMm> width) {
  constexpr float kUnit = dsp::kQuarterMmPerMetre;
  const dataset::Image<float> nothing(depth.width(), depth.height(), kNone);
  DepthPlanes planes{.depth = nothing, .low = nothing, .high = nothing};
  for (int y = 0; y < depth.height(); ++y) {
    for (int x = 0; x < depth.width(); ++x) {
      const dsp::QuarterMm raw = depth.at(x, y);
      if (raw == dsp::kNoDepth) {
        continue;
      }
      const float middle = static_cast<float>(raw);
      const float half = static_cast<float>(width.at(x, y)) / 2;
      planes.depth.view().at(x, y) = middle / kUnit;
      planes.low.view().at(x, y) = (middle - half) / kUnit;
      planes.high.view().at(x, y) = (middle + half) / kUnit;
    }
  }
  return planes;
}

dataset::Image<float> depth_from_disparity(const dataset::Image<float>& disparity,
                                           const dsp::StereoRig& rig) {
  dataset::Image<float> depth(disparity.width, disparity.height, kNone);
  for (std::size_t i = 0; i < depth.pixels.size(); ++i) {
    const double reach = static_cast<double>(disparity.pixels[i]) + rig.doff_px;
    if (std::isfinite(reach) && reach > 0) {
      depth.pixels[i] = static_cast<float>(rig.left.fx * rig.baseline_m / reach);
    }
  }
  return depth;
}

}  // namespace stof::host
