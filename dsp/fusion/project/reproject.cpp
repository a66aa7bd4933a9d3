#include "dsp/fusion/project/reproject.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <limits>

#include "dsp/base/check.h"
#include "dsp/base/index.h"
#include "dsp/fusion/project/projection.h"
#include "dsp/pmd/interval/average_pairs.h"
#include "dsp/pmd/interval/fill_intervals.h"

namespace stof::dsp {
namespace {

constexpr std::size_t kMostPlaces = 3;  // the reading and both ends of its interval

}  // namespace

Reprojector::Points Reprojector::take_points(Arena& arena, int count) noexcept {
  const std::size_t n = index(count);
  return {arena.take_passing<std::int32_t>(n), arena.take_passing<std::int32_t>(n),
          arena.take_passing<QuarterMm>(n)};
}

Reprojector::Extents Reprojector::take_extents(Arena& arena, int count) noexcept {
  const std::size_t n = index(count);
  return {arena.take_passing<std::int32_t>(n), arena.take_passing<std::int32_t>(n),
          arena.take_passing<std::int16_t>(n), arena.take_passing<std::int16_t>(n),
          arena.take_passing<std::int16_t>(n), arena.take_passing<std::int16_t>(n)};
}

Reprojector::Reprojector(const Calibration& calibration, int left_width, int left_height,
                         Arena& arena) noexcept
    : width_(calibration.pmd.lens.width),
      height_(calibration.pmd.lens.height),
      left_width_(left_width),
      left_height_(left_height) {
  constexpr int kLargest = std::numeric_limits<std::int16_t>::max();
  STOF_CHECK(left_width <= kLargest && left_height <= kLargest);
  if (width_ == 0 || height_ == 0) {
    return;
  }
  const Pinhole& left = calibration.stereo.left;
  const Pinhole& pmd = calibration.pmd.lens;
  projection_ = projection_of(calibration);
  scale_.x = static_cast<float>(left.fx / pmd.fx / 2 * kPositionOne / kQ15One);
  scale_.y = static_cast<float>(left.fy / pmd.fy / 2 * kPositionOne / kQ15One);
  rays_ = make_ray_table(calibration, arena);
  footprints_ = arena.take_passing<Footprint>(kMostPlaces * pixel_count(width_, height_));
  bands_ = arena.take_passing<Band>(index(height_));
  distance_ = arena.take_passing<QuarterMm>(index(width_));
  sigma_ = arena.take_passing<QuarterMm>(index(width_));
  low_ = take_points(arena, width_);
  centre_ = take_points(arena, width_);
  high_ = take_points(arena, width_);
  extents_ = take_extents(arena, width_);
}

void Reprojector::add_row(std::span<const std::uint8_t> flags, QuarterMm margin) noexcept {
  // All of it local: flags that are written could be part of members.
  const std::span<Footprint> all = footprints_;
  const Extents extents = extents_;
  const std::array<Points, 2> ends{low_, high_};
  const auto& [low, high] = ends;
  const std::span<const QuarterMm> depths = centre_.depth;
  std::size_t count = count_;
  const auto add = [&](PixelRange x, PixelRange y, QuarterMm depth,
                       const FootprintValue& value) noexcept {
    all[count] = {x.begin, x.end, y.begin, y.end, depth, value};
    count += x.begin < x.end && y.begin < y.end ? 1U : 0U;
  };
  for (std::size_t i = 0; i < flags.size(); ++i) {
    const std::int32_t half_x = extents.half_x[i];
    const std::int32_t half_y = extents.half_y[i];
    if (half_x == kNoFootprint) {
      continue;
    }
    const QuarterMm depth = depths[i];
    // A ray that runs towards the left camera meets the far end of its interval first.
    const QuarterMm nearer = std::min(low.depth[i], high.depth[i]);
    const QuarterMm farther = std::max(low.depth[i], high.depth[i]);
    const FootprintValue value{
        visible_behind(depth), static_cast<QuarterMm>(std::max(nearer - margin, 1)),
        static_cast<QuarterMm>(std::min<int>(farther + margin, kMaxQuarterMm)), flags[i]};
    add({extents.x_begin[i], extents.x_end[i]}, {extents.y_begin[i], extents.y_end[i]}, depth,
        value);
    const bool ends_apart = low.depth[i] == kNoDepth || high.depth[i] == kNoDepth ||
                            std::abs(low.u[i] - high.u[i]) > half_x ||
                            std::abs(low.v[i] - high.v[i]) > half_y;
    if (!ends_apart) {
      continue;
    }
    for (const Points& end : ends) {
      if (end.depth[i] != kNoDepth) {
        add(footprint_range(end.u[i], half_x, left_width_),
            footprint_range(end.v[i], half_y, left_height_), depth, value);
      }
    }
  }
  count_ = count;
}

Reprojector::Band Reprojector::band(std::size_t begin) const noexcept {
  Band band{static_cast<std::uint32_t>(begin), static_cast<std::uint32_t>(count_ - begin), 0, 0};
  for (const Footprint& f : footprints().subspan(begin)) {
    const bool first = band.y_begin == band.y_end;
    band.y_begin = first ? f.y_begin : std::min(band.y_begin, f.y_begin);
    band.y_end = std::max(band.y_end, f.y_end);
  }
  return band;
}

std::span<const QuarterMm> Reprojector::average(const PmdMaps& maps, int y) noexcept {
  if (maps.sigma.empty() || y == 0 || y == height_ - 1) {  // without opposite neighbours
    return maps.located().row(y);
  }
  best::average_pairs(located_rows(maps, y), maps.slope_q16, distance_, sigma_);
  return distance_;
}

void Reprojector::locate_row(const PmdMaps& maps, int y, QuarterMm margin) noexcept {
  const RayRow rays = ray_row(rays_, width_, y);
  const std::span<const QuarterMm> distance = average(maps, y);
  best::project(rays, maps.low.row(y), projection_, low_.u, low_.v, low_.depth);
  best::project(rays, distance, projection_, centre_.u, centre_.v, centre_.depth);
  best::project(rays, maps.high.row(y), projection_, high_.u, high_.v, high_.depth);
  best::half_sizes(distance, rays_.forward.subspan(pixel_count(width_, y), index(width_)),
                   centre_.depth, scale_, extents_.half_x, extents_.half_y);
  best::footprint_ranges(centre_.u, extents_.half_x, left_width_, extents_.x_begin, extents_.x_end);
  best::footprint_ranges(centre_.v, extents_.half_y, left_height_, extents_.y_begin,
                         extents_.y_end);
  const std::size_t before = count_;
  add_row(maps.flags.row(y), margin);
  bands_[index(y)] = band(before);
}

void Reprojector::locate(const PmdMaps& maps, QuarterMm margin) noexcept {
  STOF_CHECK(maps.distance.width() == width_ && maps.distance.height() == height_);
  STOF_CHECK(same_size(maps.low, maps.distance) && same_size(maps.high, maps.distance) &&
             same_size(maps.flags, maps.distance));
  count_ = 0;
  for (int y = 0; y < height_; ++y) {
    locate_row(maps, y, margin);
  }
}

void Reprojector::splat(Rows rows, const SplattedView& view) const noexcept {
  STOF_CHECK(rows.begin >= 0 && rows.end <= left_height_);
  STOF_CHECK(view.low.width() == left_width_ && view.low.height() == left_height_);
  STOF_CHECK(same_size(view.nearest, view.low) && same_size(view.high, view.low) &&
             same_size(view.flags, view.low));
  for (int y = rows.begin; y < rows.end; ++y) {
    std::ranges::fill(view.nearest.row(y), kNoSplat);
    std::ranges::fill(view.low.row(y), kNoSplat);
    std::ranges::fill(view.high.row(y), QuarterMm{0});
    std::ranges::fill(view.flags.row(y), std::uint8_t{0});
  }
  if (count_ == 0) {
    return;
  }
  for (const Band& band : bands_) {
    if (band.y_begin < rows.end && rows.begin < band.y_end) {
      best::splat_nearest(footprints().subspan(band.begin, band.count), rows, view.nearest);
    }
  }
  for (const Band& band : bands_) {
    if (band.y_begin < rows.end && rows.begin < band.y_end) {
      best::splat_intervals(footprints().subspan(band.begin, band.count), rows, view);
    }
  }
}

}  // namespace stof::dsp
