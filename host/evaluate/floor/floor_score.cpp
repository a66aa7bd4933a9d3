#include "host/evaluate/floor/floor_score.h"

#include <cmath>
#include <limits>
#include <numbers>
#include <utility>
#include <vector>

#include "host/evaluate/fusion/depth_score.h"
#include "host/evaluate/mean_of.h"
#include "host/evaluate/share.h"
#include "host/evaluate/stereo/median.h"

namespace stof::host {
namespace {

using dataset::Surface;

class SurfaceCounter {
 public:
  void add(double depth, double truth) {
    const bool has_depth = std::isfinite(depth);
    const double error = std::abs(depth - truth);
    missing_.count(!has_depth);
    off_.count(has_depth && error > kLargestRelativeError * truth);
    if (has_depth) {
      errors_.push_back(error);
    }
  }
  SurfaceScore score() const {
    return {.pixels = off_.counted(),
            .off = off_.value(),
            .missing = missing_.value(),
            .median_error_m = median(errors_),
            .p95_error_m = percentile(errors_, 0.95)};
  }

 private:
  Share off_;
  Share missing_;
  std::vector<double> errors_;
};

// How far above the floor a depth in a row of the left picture is.
class HeightAboveFloor {
 public:
  HeightAboveFloor(const dataset::FloorTruth& floor, const dsp::Pinhole& lens)
      : camera_m_(floor.height_m),
        sine_(std::sin(floor.tilt_degrees * std::numbers::pi / 180)),
        cosine_(std::cos(floor.tilt_degrees * std::numbers::pi / 180)),
        lens_(lens) {}
  double of(int row, double depth) const {
    const double down = (row - lens_.cy) / lens_.fy;
    return camera_m_ - depth * (down * cosine_ + sine_);
  }

 private:
  double camera_m_;
  double sine_;
  double cosine_;
  const dsp::Pinhole& lens_;
};

}  // namespace

std::optional<double> floor_above_pose(const FloorReference& reference) {
  const HeightAboveFloor height(reference.floor, reference.lens);
  std::vector<double> above;
  for (std::size_t i = 0; i < reference.depth.pixels.size(); ++i) {
    const double truth = static_cast<double>(reference.depth.pixels[i]);
    if (reference.floor.surface.pixels[i] == Surface::kFloor && truth <= kFloorReachM) {
      above.push_back(height.of(static_cast<int>(i) / reference.depth.width, truth));
    }
  }
  return median(std::move(above));
}

FloorScore score_floor(const dataset::Image<float>& depth, std::span<const dsp::Source> source,
                       const FloorReference& reference) {
  const HeightAboveFloor height(reference.floor, reference.lens);
  std::array<SurfaceCounter, dataset::kSurfaces> counters;
  Share missing_anywhere;
  Share obstacle;
  Share no_drop;
  Share conflict;
  for (std::size_t i = 0; i < depth.pixels.size(); ++i) {
    const double truth = static_cast<double>(reference.depth.pixels[i]);
    const double z = static_cast<double>(depth.pixels[i]);
    const Surface surface = reference.floor.surface.pixels[i];
    const bool floor = surface == Surface::kFloor;
    if (!std::isfinite(truth) || (floor && truth > kFloorReachM)) {
      continue;
    }
    if (floor) {
      missing_anywhere.count(!std::isfinite(z));
    }
    if (reference.visible.pixels[i] == 0) {
      continue;
    }
    counters.at(static_cast<std::size_t>(surface)).add(z, truth);
    const int row = static_cast<int>(i) / depth.width;
    const double above =
        std::isfinite(z) ? height.of(row, z) : -std::numeric_limits<double>::infinity();
    if (floor) {
      obstacle.count(above > kObstacleM);
    } else if (surface == Surface::kLowerFloor) {
      no_drop.count(above > height.of(row, truth) / 2);
    } else if (surface == Surface::kGlass && !source.empty()) {
      conflict.count(source[i] == dsp::Source::kConflict);
    }
  }
  FloorScore score{.surfaces = {},
                   .missing_anywhere = missing_anywhere.value(),
                   .obstacle = obstacle.value(),
                   .no_drop = no_drop.value(),
                   .conflict = conflict.value()};
  for (std::size_t k = 0; k < counters.size(); ++k) {
    score.surfaces[k] = counters[k].score();
  }
  return score;
}

FloorScore mean_score(std::span<const FloorScore> scores) {
  FloorScore mean{.surfaces = {},
                  .missing_anywhere = mean_of(scores, &FloorScore::missing_anywhere),
                  .obstacle = mean_of(scores, &FloorScore::obstacle),
                  .no_drop = mean_of(scores, &FloorScore::no_drop),
                  .conflict = mean_of(scores, &FloorScore::conflict)};
  for (std::size_t k = 0; k < mean.surfaces.size(); ++k) {
    std::vector<SurfaceScore> parts;
    for (const FloorScore& score : scores) {
      parts.push_back(score.surfaces[k]);
      mean.surfaces[k].pixels += score.surfaces[k].pixels;
    }
    const std::span<const SurfaceScore> all(parts);
    mean.surfaces[k].off = mean_of(all, &SurfaceScore::off);
    mean.surfaces[k].missing = mean_of(all, &SurfaceScore::missing);
    mean.surfaces[k].median_error_m = mean_of(all, &SurfaceScore::median_error_m);
    mean.surfaces[k].p95_error_m = mean_of(all, &SurfaceScore::p95_error_m);
  }
  return mean;
}

}  // namespace stof::host
