#include "dsp/stereo/rectify/rectify.h"

#include <algorithm>
#include <cstddef>

#include "dsp/base/check.h"
#include "dsp/base/fixed.h"

namespace stof::dsp {
namespace {

// Steps of 1/128 px from the tile's corner; 0: x, 1: y.
int steps(const PlaceTile& tile, const std::array<float, 8>& numbers, std::size_t axis,
          int k) noexcept {
  const auto whole = [&](std::size_t i) noexcept {
    return std::int64_t{static_cast<std::int32_t>(numbers[4 * axis + i])};
  };
  const std::int64_t sum = whole(0) + whole(1) * k + (whole(2) - kTileBias) * tile_bend(k) +
                           (whole(3) - kTileBias) * tile_twist(k);
  return std::clamp(static_cast<int>(sum >> kTileFractionBits), int{tile.low[axis]},
                    int{tile.high[axis]});
}

}  // namespace

std::array<float, 8> tile_line(const PlaceTile& tile, int line) noexcept {
  const float t = static_cast<float>(2 * line - (kTileSide - 1)) / kTileSide;
  std::array<float, 8> sums{};
  for (std::size_t i = 0; i < sums.size(); ++i) {
    sums[i] = tile.powers[0][i] + tile.powers[1][i] * t;
    sums[i] = sums[i] + tile.powers[2][i] * (t * t);
    sums[i] = sums[i] + tile.powers[3][i] * (t * t * t);
  }
  return sums;
}

Place place_of(const PlaceTile& tile, const std::array<float, 8>& numbers, int column) noexcept {
  const int x = tile.x * kPlaceOne + steps(tile, numbers, 0, column);
  const int y = tile.y * kPlaceOne + steps(tile, numbers, 1, column);
  return {.x = static_cast<std::uint16_t>(x / kPlaceOne),
          .y = static_cast<std::uint16_t>(y / kPlaceOne),
          .fraction_x = static_cast<std::uint8_t>(x % kPlaceOne),
          .fraction_y = static_cast<std::uint8_t>(y % kPlaceOne)};
}

std::uint8_t mix(ImageView<const std::uint8_t> source, const Place& place) noexcept {
  const std::uint8_t* const upper = &source.at(place.x, place.y);
  const std::uint8_t* const lower = upper + source.stride();
  const int above = upper[0] * kPlaceOne + (upper[1] - upper[0]) * place.fraction_x;
  const int below = lower[0] * kPlaceOne + (lower[1] - lower[0]) * place.fraction_x;
  const int mixed = above + round_shift((below - above) * place.fraction_y, kPlaceFractionBits);
  return static_cast<std::uint8_t>(round_shift(mixed, kPlaceFractionBits));
}

namespace ref {

void remap_row(ImageView<const std::uint8_t> source, std::span<const PlaceTile> tiles, int line,
               std::span<std::uint8_t> out) noexcept {
  STOF_CHECK(out.size() <= tiles.size() * kTileSide && line >= 0 && line < kTileSide);
  for (const PlaceTile& tile : tiles) {
    const std::span<std::uint8_t> part = out.first(std::min<std::size_t>(out.size(), kTileSide));
    out = out.subspan(part.size());
    if (!tile.serves) {
      continue;
    }
    const std::array<float, 8> numbers = tile_line(tile, line);
    for (std::size_t k = 0; k < part.size(); ++k) {
      part[k] = mix(source, place_of(tile, numbers, static_cast<int>(k)));
    }
  }
}

}  // namespace ref
}  // namespace stof::dsp
