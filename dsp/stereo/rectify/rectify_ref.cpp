#include "dsp/stereo/rectify/rectify.h"

#include <algorithm>
#include <cstddef>

#include "dsp/base/check.h"
#include "dsp/base/fixed.h"

namespace stof::dsp {
namespace {

// Steps of 1/128 px from the patch's corner; 0: x, 1: y.
int steps(const PlacePatch& patch, const std::array<float, 8>& numbers, std::size_t axis,
          int k) noexcept {
  const auto whole = [&](std::size_t i) noexcept {
    return std::int64_t{static_cast<std::int32_t>(numbers[4 * axis + i])};
  };
  const std::int64_t sum = whole(0) + whole(1) * k + (whole(2) - kPatchBias) * patch_bend(k) +
                           (whole(3) - kPatchBias) * patch_twist(k);
  return std::clamp(static_cast<int>(sum >> kPatchFractionBits), int{patch.low[axis]},
                    int{patch.high[axis]});
}

}  // namespace

std::array<float, 8> patch_line(const PlacePatch& patch, int line) noexcept {
  const float t = static_cast<float>(2 * line - (kPatchSide - 1)) / kPatchSide;
  std::array<float, 8> sums{};
  for (std::size_t i = 0; i < sums.size(); ++i) {
    sums[i] = patch.powers[0][i] + patch.powers[1][i] * t;
    sums[i] = sums[i] + patch.powers[2][i] * (t * t);
    sums[i] = sums[i] + patch.powers[3][i] * (t * t * t);
  }
  return sums;
}

Place place_of(const PlacePatch& patch, const std::array<float, 8>& numbers, int column) noexcept {
  const int x = patch.x * kPlaceOne + steps(patch, numbers, 0, column);
  const int y = patch.y * kPlaceOne + steps(patch, numbers, 1, column);
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

void remap_row(ImageView<const std::uint8_t> source, std::span<const PlacePatch> patches, int line,
               std::span<std::uint8_t> out) noexcept {
  STOF_CHECK(out.size() <= patches.size() * kPatchSide && line >= 0 && line < kPatchSide);
  for (const PlacePatch& patch : patches) {
    const std::span<std::uint8_t> part = out.first(std::min<std::size_t>(out.size(), kPatchSide));
    out = out.subspan(part.size());
    if (!patch.serves) {
      continue;
    }
    const std::array<float, 8> numbers = patch_line(patch, line);
    for (std::size_t k = 0; k < part.size(); ++k) {
      part[k] = mix(source, place_of(patch, numbers, static_cast<int>(k)));
    }
  }
}

}  // namespace ref
}  // namespace stof::dsp
