#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <vector>

#include "dsp/calib/pmd/ray_table.h"
#include "dsp/fusion/project/reproject.h"

// What Reprojector splats, written down plainly: pixel by pixel, as its header says.
namespace stof::dsp {

struct PlainPlace {
  std::int32_t u = 0;
  std::int32_t v = 0;
  QuarterMm depth = kNoDepth;
};

struct PlainReading {
  std::vector<PlainPlace> places;
  int half_x = 0;
  int half_y = 0;
  QuarterMm depth = 0;
  QuarterMm low = 0;
  QuarterMm high = 0;
  std::uint8_t flags = 0;
};

class PlainReprojector {
 public:
  PlainReprojector(const Calibration& rig, PmdMaps maps) : rig_(rig) {
    const std::size_t n = static_cast<std::size_t>(rig.pmd.lens.width) *
                          static_cast<std::size_t>(rig.pmd.lens.height);
    for (std::vector<std::int16_t>* const table : {&x_, &y_, &z_, &forward_}) {
      table->resize(n);
    }
    fill_ray_table(rig.pmd.lens, rig.pmd_to_stereo.rotation, {x_, y_, z_, forward_});
    for (int y = 0; y < rig.pmd.lens.height; ++y) {
      for (int x = 0; x < rig.pmd.lens.width; ++x) {
        read(maps, x, y);
      }
    }
  }

  const std::vector<PlainReading>& readings() const { return readings_; }

  void splat(const SplattedView& view) const {
    for (int y = 0; y < view.low.height(); ++y) {
      std::ranges::fill(view.nearest.row(y), kNoSplat);
      std::ranges::fill(view.low.row(y), kNoSplat);
      std::ranges::fill(view.high.row(y), QuarterMm{0});
      std::ranges::fill(view.flags.row(y), std::uint8_t{0});
    }
    over_pixels(view, [&](const PlainReading& reading, int x, int y) {
      view.nearest.at(x, y) = std::min(view.nearest.at(x, y), reading.depth);
    });
    over_pixels(view, [&](const PlainReading& reading, int x, int y) {
      if (std::uint32_t{reading.depth} * 50 <= std::uint32_t{view.nearest.at(x, y)} * 51) {
        view.low.at(x, y) = std::min(view.low.at(x, y), reading.low);
        view.high.at(x, y) = std::max(view.high.at(x, y), reading.high);
        view.flags.at(x, y) |= reading.flags;
      }
    });
  }

 private:
  PlainPlace place(std::size_t i, QuarterMm distance) const {
    const Pinhole& left = rig_.stereo.left;
    Projection projection{.focal_x = static_cast<float>(left.fx * kPositionOne),
                          .focal_y = static_cast<float>(left.fy * kPositionOne),
                          .centre_x = static_cast<float>(left.cx * kPositionOne),
                          .centre_y = static_cast<float>(left.cy * kPositionOne)};
    for (std::size_t k = 0; k < 3; ++k) {
      projection.origin[k] =
          static_cast<std::int32_t>(std::lround(rig_.pmd_to_stereo.translation_m[k] * 4000));
    }
    PlainPlace place;
    ref::project({{&x_[i], 1}, {&y_[i], 1}, {&z_[i], 1}}, {&distance, 1}, projection, {&place.u, 1},
                 {&place.v, 1}, {&place.depth, 1});
    return place;
  }

  static int half(double left_focal, double pmd_focal, float ratio) {
    const float scale = static_cast<float>(left_focal / pmd_focal / 2 * kPositionOne / kQ15One);
    return static_cast<int>(std::min(scale * ratio + 0.6F * 16, 1048576.0F));
  }

  void read(const PmdMaps& maps, int x, int y) {
    const std::size_t i =
        static_cast<std::size_t>(y) * static_cast<std::size_t>(maps.distance.width()) +
        static_cast<std::size_t>(x);
    const QuarterMm distance = maps.distance.at(x, y);
    const PlainPlace centre = place(i, distance);
    if (distance == kNoDepth || centre.depth == kNoDepth || forward_[i] <= 0) {
      return;
    }
    const float ratio = static_cast<float>(distance) * static_cast<float>(forward_[i]) /
                        static_cast<float>(centre.depth);
    const PlainPlace low = place(i, maps.low.at(x, y));
    const PlainPlace high = place(i, maps.high.at(x, y));
    PlainReading reading{.places = {centre},
                         .half_x = half(rig_.stereo.left.fx, rig_.pmd.lens.fx, ratio),
                         .half_y = half(rig_.stereo.left.fy, rig_.pmd.lens.fy, ratio),
                         .depth = centre.depth,
                         .low = std::max<QuarterMm>(std::min(low.depth, high.depth), 1),
                         .high = std::max(low.depth, high.depth),
                         .flags = maps.flags.at(x, y)};
    if (low.depth == kNoDepth || high.depth == kNoDepth ||
        std::abs(low.u - high.u) > reading.half_x || std::abs(low.v - high.v) > reading.half_y) {
      reading.places.push_back(low);
      reading.places.push_back(high);
      std::erase_if(reading.places, [](const PlainPlace& at) { return at.depth == kNoDepth; });
    }
    readings_.push_back(reading);
  }

  // The first and last of `size` pixels within `half` of a place, all in 1/16 px.
  static std::array<int, 2> within(std::int32_t place, int half, int size) {
    std::array<int, 2> ends{size, -1};
    for (int x = 0; x < size; ++x) {
      if (std::abs(kPositionOne * x - place) <= half) {
        ends = {std::min(ends[0], x), x};
      }
    }
    return ends;
  }

  template <typename Visit>
  void over_pixels(const SplattedView& view, Visit visit) const {
    for (const PlainReading& reading : readings_) {
      for (const PlainPlace& place : reading.places) {
        const auto [left, right] = within(place.u, reading.half_x, view.low.width());
        const auto [top, bottom] = within(place.v, reading.half_y, view.low.height());
        for (int y = top; y <= bottom; ++y) {
          for (int x = left; x <= right; ++x) {
            visit(reading, x, y);
          }
        }
      }
    }
  }

  Calibration rig_;
  std::vector<std::int16_t> x_, y_, z_, forward_;
  std::vector<PlainReading> readings_;
};

}  // namespace stof::dsp
