#include "host/evaluate/depth_score.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "host/evaluate/median.h"

namespace stof::host {
namespace {

constexpr float kNone = std::numeric_limits<float>::infinity();
constexpr double kLargestRelativeError = 0.05;

}  // namespace

DepthScore score_depth(const DepthPlanes& planes, const dataset::Image<float>& truth) {
  DepthScore score;
  std::vector<double> errors;
  std::vector<double> relative;
  std::vector<double> widths;
  std::size_t bad = 0;
  std::size_t hits = 0;
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
    hits += low <= z && z <= high ? 1U : 0U;
    errors.push_back(error);
    relative.push_back(error / z);
    widths.push_back(high - low);
  }
  if (score.truth_pixels > 0) {
    score.e5 = static_cast<double>(bad) / static_cast<double>(score.truth_pixels);
    score.coverage = static_cast<double>(errors.size()) / static_cast<double>(score.truth_pixels);
  }
  if (!errors.empty()) {
    score.hit_rate = static_cast<double>(hits) / static_cast<double>(errors.size());
  }
  score.median_error_m = median(std::move(errors));
  score.median_relative = median(std::move(relative));
  score.median_width_m = median(std::move(widths));
  return score;
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
