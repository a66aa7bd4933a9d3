#include "dsp/fusion/reproject.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <limits>

#include "dsp/base/check.h"
#include "dsp/calib/ray_table.h"

namespace stof::dsp {
namespace {

constexpr float kMargin = 0.6F * kPositionOne;
constexpr std::size_t kMostPlaces = 3;  // the reading and both ends of its interval

std::size_t pixels(int width, int height) noexcept {
  return static_cast<std::size_t>(width) * static_cast<std::size_t>(height);
}

// Pixels begin .. end - 1 of 0 .. size - 1 whose centres lie within `half` of `centre` (1/16 px).
struct Span {
  std::int16_t begin;
  std::int16_t end;
};
Span covered(std::int32_t centre, int half, int size) noexcept {
  const int begin = (centre - half + kPositionOne - 1) >> kPositionBits;
  const int end = ((centre + half) >> kPositionBits) + 1;
  return {static_cast<std::int16_t>(std::clamp(begin, 0, size)),
          static_cast<std::int16_t>(std::clamp(end, 0, size))};
}

int half_size(float scale, float ratio) noexcept {
  return static_cast<int>(std::min(scale * ratio + kMargin, float{kFarthestPosition}));
}

template <typename T>
std::span<T> segment(const ImageView<T>& image, const Footprint& footprint, int y) noexcept {
  return image.row(y).subspan(static_cast<std::size_t>(footprint.x_begin),
                              static_cast<std::size_t>(footprint.x_end - footprint.x_begin));
}

Rows common(const Footprint& footprint, Rows rows) noexcept {
  return {std::max<int>(footprint.y_begin, rows.begin), std::min<int>(footprint.y_end, rows.end)};
}

}  // namespace

std::size_t Reprojector::bytes_needed(int pmd_width, int pmd_height) noexcept {
  const std::size_t all = pixels(pmd_width, pmd_height);
  const std::size_t row = static_cast<std::size_t>(pmd_width);
  return 4 * Arena::bytes_for<std::int16_t>(all) + Arena::bytes_for<Footprint>(kMostPlaces * all) +
         6 * Arena::bytes_for<std::int32_t>(row) + 3 * Arena::bytes_for<QuarterMm>(row);
}

Reprojector::Points Reprojector::take_points(Arena& arena, int count) noexcept {
  const std::size_t n = static_cast<std::size_t>(count);
  return {arena.take<std::int32_t>(n), arena.take<std::int32_t>(n), arena.take<QuarterMm>(n)};
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
  for (std::size_t k = 0; k < 3; ++k) {
    projection_.origin[k] = static_cast<std::int32_t>(
        std::lround(calibration.pmd_to_stereo.translation_m[k] * kQuarterMmPerMetre));
  }
  projection_.focal_x = static_cast<float>(left.fx * kPositionOne);
  projection_.focal_y = static_cast<float>(left.fy * kPositionOne);
  projection_.centre_x = static_cast<float>(left.cx * kPositionOne);
  projection_.centre_y = static_cast<float>(left.cy * kPositionOne);
  half_x_ = static_cast<float>(left.fx / pmd.fx / 2 * kPositionOne / kQ15One);
  half_y_ = static_cast<float>(left.fy / pmd.fy / 2 * kPositionOne / kQ15One);
  const std::size_t all = pixels(width_, height_);
  ray_x_ = arena.take<std::int16_t>(all);
  ray_y_ = arena.take<std::int16_t>(all);
  ray_z_ = arena.take<std::int16_t>(all);
  forward_ = arena.take<std::int16_t>(all);
  fill_ray_table(pmd, calibration.pmd_to_stereo.rotation, {ray_x_, ray_y_, ray_z_, forward_});
  footprints_ = arena.take<Footprint>(kMostPlaces * all);
  low_ = take_points(arena, width_);
  centre_ = take_points(arena, width_);
  high_ = take_points(arena, width_);
}

void Reprojector::add(std::int32_t u, std::int32_t v, int half_x, int half_y, QuarterMm depth,
                      const Paint& paint) noexcept {
  const Span x = covered(u, half_x, left_width_);
  const Span y = covered(v, half_y, left_height_);
  if (x.begin < x.end && y.begin < y.end) {
    footprints_[count_] = {x.begin, x.end, y.begin, y.end, depth, paint};
    ++count_;
  }
}

void Reprojector::locate_pixel(std::size_t i, QuarterMm distance, std::int16_t forward,
                               std::uint8_t flags) noexcept {
  const QuarterMm depth = centre_.depth[i];
  const float ratio = static_cast<float>(distance) * forward / static_cast<float>(depth);
  const int half_x = half_size(half_x_, ratio);
  const int half_y = half_size(half_y_, ratio);
  // A ray that runs towards the left camera meets the far end of its interval first.
  const auto [low, high] = std::minmax(low_.depth[i], high_.depth[i]);
  const Paint paint{visible_behind(depth), std::max<QuarterMm>(low, 1), high, flags};
  add(centre_.u[i], centre_.v[i], half_x, half_y, depth, paint);
  if (low != kNoDepth && std::abs(low_.u[i] - high_.u[i]) <= half_x &&
      std::abs(low_.v[i] - high_.v[i]) <= half_y) {
    return;
  }
  for (const Points* end : {&low_, &high_}) {
    if (end->depth[i] != kNoDepth) {
      add(end->u[i], end->v[i], half_x, half_y, depth, paint);
    }
  }
}

void Reprojector::locate_row(const PmdMaps& maps, int y) noexcept {
  const std::size_t n = static_cast<std::size_t>(width_);
  const std::size_t first = pixels(width_, y);
  const RayRow rays{ray_x_.subspan(first, n), ray_y_.subspan(first, n), ray_z_.subspan(first, n)};
  const std::span<const QuarterMm> distance = maps.distance.row(y);
  const std::span<const std::uint8_t> flags = maps.flags.row(y);
  best::project(rays, maps.low.row(y), projection_, low_.u, low_.v, low_.depth);
  best::project(rays, distance, projection_, centre_.u, centre_.v, centre_.depth);
  best::project(rays, maps.high.row(y), projection_, high_.u, high_.v, high_.depth);
  for (std::size_t i = 0; i < n; ++i) {
    const std::int16_t forward = forward_[first + i];
    if (distance[i] != kNoDepth && centre_.depth[i] != kNoDepth && forward > 0) {
      locate_pixel(i, distance[i], forward, flags[i]);
    }
  }
}

void Reprojector::locate(const PmdMaps& maps) noexcept {
  STOF_CHECK(maps.distance.width() == width_ && maps.distance.height() == height_);
  STOF_CHECK(same_size(maps.low, maps.distance) && same_size(maps.high, maps.distance) &&
             same_size(maps.flags, maps.distance));
  count_ = 0;
  for (int y = 0; y < height_; ++y) {
    locate_row(maps, y);
  }
}

void Reprojector::paint(Rows rows, const PaintedView& view) const noexcept {
  STOF_CHECK(rows.begin >= 0 && rows.end <= left_height_);
  STOF_CHECK(view.low.width() == left_width_ && view.low.height() == left_height_);
  STOF_CHECK(same_size(view.nearest, view.low) && same_size(view.high, view.low) &&
             same_size(view.flags, view.low));
  for (int y = rows.begin; y < rows.end; ++y) {
    std::ranges::fill(view.nearest.row(y), kNothingPainted);
    std::ranges::fill(view.low.row(y), kNothingPainted);
    std::ranges::fill(view.high.row(y), QuarterMm{0});
    std::ranges::fill(view.flags.row(y), std::uint8_t{0});
  }
  for (const Footprint& f : footprints()) {
    const Rows some = common(f, rows);
    for (int y = some.begin; y < some.end; ++y) {
      best::paint_nearest(f.depth, segment(view.nearest, f, y));
    }
  }
  for (const Footprint& f : footprints()) {
    const Rows some = common(f, rows);
    for (int y = some.begin; y < some.end; ++y) {
      best::paint_interval(f.paint, segment(view.nearest, f, y), segment(view.low, f, y),
                           segment(view.high, f, y), segment(view.flags, f, y));
    }
  }
}

}  // namespace stof::dsp
