#include "dsp/stereo/refine/least_squares.h"

#include <algorithm>
#include <cstddef>
#include <cstdlib>

#include "dsp/base/check.h"

namespace stof::dsp {
namespace {

int pixel(std::span<const std::uint8_t> row, int x) noexcept {
  return row[static_cast<std::size_t>(std::clamp(x, 0, static_cast<int>(row.size()) - 1))];
}

}  // namespace

Disparity shifted_disparity(int whole, std::int32_t moment, std::int32_t energy) noexcept {
  const std::int64_t size = std::abs(std::int64_t{moment});
  if (4 * size > energy) {
    return Disparity::none();
  }
  if (energy == 0) {
    return Disparity::from_pixels(whole);
  }
  const std::int64_t sixteenths = (64 * size + energy) / (2 * std::int64_t{energy});
  const std::int64_t shift = moment < 0 ? -sixteenths : sixteenths;
  return Disparity::from_raw(static_cast<std::int16_t>(whole * Disparity::kOne + shift));
}

Disparity least_squares_at(ImageView<const std::uint8_t> left, ImageView<const std::uint8_t> right,
                           int x, int y, int block_width, int block_height,
                           Disparity disparity) noexcept {
  if (!disparity.valid()) {
    return disparity;
  }
  const int whole = round_shift<int>(disparity.raw, Disparity::kFractionBits);
  std::int32_t moment = 0;
  std::int32_t energy = 0;
  for (int row = y - block_height / 2; row < y - block_height / 2 + block_height; ++row) {
    const std::span<const std::uint8_t> g = left.row_clamped(row);
    const std::span<const std::uint8_t> f = right.row_clamped(row);
    for (int k = x - block_width / 2; k < x - block_width / 2 + block_width; ++k) {
      const int derivative = pixel(g, k + 1) - pixel(g, k - 1);
      moment += derivative * (pixel(f, k - whole) - pixel(g, k));
      energy += derivative * derivative;
    }
  }
  return shifted_disparity(whole, moment, energy);
}

namespace ref {

void refine_least_squares(ImageView<const std::uint8_t> left, ImageView<const std::uint8_t> right,
                          int y, int block_width, int block_height,
                          std::span<Disparity> disparities) noexcept {
  STOF_CHECK(same_size(left, right) && y >= 0 && y < left.height() && block_width >= 1 &&
             block_width <= 64 && block_height >= 1 && block_height <= 64 &&
             disparities.size() == static_cast<std::size_t>(left.width()));
  for (int x = 0; x < left.width(); ++x) {
    Disparity& disparity = disparities[static_cast<std::size_t>(x)];
    disparity = least_squares_at(left, right, x, y, block_width, block_height, disparity);
  }
}

}  // namespace ref
}  // namespace stof::dsp
