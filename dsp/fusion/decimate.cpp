#include "dsp/fusion/decimate.h"

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <span>

#include "dsp/base/check.h"
#include "dsp/base/index.h"

namespace stof::dsp {
namespace {

// A key orders pixels by near bound, then by raster order: 2 depth - width + 65535 above the place
// in the block.
constexpr int kPlaceBits = 12;
constexpr std::uint32_t kNoPixel = std::numeric_limits<std::uint32_t>::max();
static_assert(kMostBlock * kMostBlock == 1 << kPlaceBits);
static_assert((3ULL * kMaxQuarterMm << kPlaceBits) + (1 << kPlaceBits) <= kNoPixel);

std::uint32_t nearest_key(std::span<const QuarterMm> depth, std::span<const QuarterMm> width,
                          std::uint32_t first_place) noexcept {
  std::uint32_t nearest = kNoPixel;
  for (std::size_t i = 0; i < depth.size(); ++i) {
    const std::uint32_t bound = 2 * std::uint32_t{depth[i]} + kMaxQuarterMm - width[i];
    const std::uint32_t key = (bound << kPlaceBits) + first_place + static_cast<std::uint32_t>(i);
    nearest = std::min(nearest, depth[i] == kNoDepth ? kNoPixel : key);
  }
  return nearest;
}

}  // namespace

NearestPixel nearest_pixel(const DepthMap& map, int step, int column, int row) noexcept {
  STOF_CHECK(step >= kLeastBlock && step <= kMostBlock);
  const int left = column * step;
  const int top = row * step;
  const int columns = std::min(step, map.depth.width() - left);
  const int bottom = std::min(top + step, map.depth.height());
  STOF_CHECK(columns > 0 && bottom > top);
  const auto at = index(left);
  const auto count = index(columns);
  std::uint32_t nearest = kNoPixel;
  for (int y = top; y < bottom; ++y) {
    const std::uint32_t key =
        nearest_key(map.depth.row(y).subspan(at, count), map.width.row(y).subspan(at, count),
                    static_cast<std::uint32_t>((y - top) * step));
    nearest = std::min(nearest, key);
  }
  if (nearest == kNoPixel) {
    return {.x = left, .y = top};
  }
  const int place = static_cast<int>(nearest % (1U << kPlaceBits));
  const int x = left + place % step;
  const int y = top + place / step;
  return {.x = x, .y = y, .depth = map.depth.at(x, y), .width = map.width.at(x, y)};
}

void decimate(const DepthMap& map, int step, ImageView<QuarterMm> depth,
              ImageView<QuarterMm> width) noexcept {
  STOF_CHECK(same_size(map.depth, map.width) && same_size(depth, width));
  STOF_CHECK(depth.width() == decimated(map.depth.width(), step));
  STOF_CHECK(depth.height() == decimated(map.depth.height(), step));
  for (int row = 0; row < depth.height(); ++row) {
    for (int column = 0; column < depth.width(); ++column) {
      const NearestPixel pixel = nearest_pixel(map, step, column, row);
      depth.at(column, row) = pixel.depth;
      width.at(column, row) = pixel.width;
    }
  }
}

}  // namespace stof::dsp
