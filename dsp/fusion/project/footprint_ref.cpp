#include "dsp/fusion/project/footprint.h"

#include <algorithm>
#include <cstddef>

#include "dsp/base/check.h"

namespace stof::dsp::ref {
namespace {

std::int32_t half_size(float scale, float ratio) noexcept {
  const float half = scale * ratio + kFootprintMargin;
  return static_cast<std::int32_t>(std::min(half, float{kFarthestPosition}));
}

}  // namespace

void half_sizes(std::span<const QuarterMm> distance, std::span<const std::int16_t> forward,
                std::span<const QuarterMm> depth, const FootprintScale& scale,
                std::span<std::int32_t> half_x, std::span<std::int32_t> half_y) noexcept {
  const std::size_t n = distance.size();
  STOF_CHECK(forward.size() == n && depth.size() == n && half_x.size() == n && half_y.size() == n);
  for (std::size_t i = 0; i < n; ++i) {
    half_x[i] = kNoFootprint;
    half_y[i] = kNoFootprint;
    if (distance[i] != kNoDepth && depth[i] != kNoDepth && forward[i] > 0) {
      const float along = static_cast<float>(distance[i]) * static_cast<float>(forward[i]);
      const float ratio = along / static_cast<float>(depth[i]);
      half_x[i] = half_size(scale.x, ratio);
      half_y[i] = half_size(scale.y, ratio);
    }
  }
}

void footprint_ranges(std::span<const std::int32_t> place, std::span<const std::int32_t> half,
                      int size, std::span<std::int16_t> begin,
                      std::span<std::int16_t> end) noexcept {
  const std::size_t n = place.size();
  STOF_CHECK(half.size() == n && begin.size() == n && end.size() == n);
  for (std::size_t i = 0; i < n; ++i) {
    const PixelRange range = footprint_range(place[i], half[i], size);
    begin[i] = range.begin;
    end[i] = range.end;
  }
}

}  // namespace stof::dsp::ref
