#include "dsp/stereo/rectify.h"

#include <cstddef>

#include "dsp/base/check.h"
#include "dsp/base/fixed.h"

namespace stof::dsp::ref {

void remap_row(ImageView<const std::uint8_t> source, const RemapRow& places,
               std::span<std::uint8_t> out) noexcept {
  const std::size_t n = out.size();
  STOF_CHECK(places.x.size() == n && places.y.size() == n);
  STOF_CHECK(places.fraction_x.size() == n && places.fraction_y.size() == n);
  for (std::size_t i = 0; i < n; ++i) {
    const std::uint8_t* const upper = &source.at(places.x[i], places.y[i]);
    const std::uint8_t* const lower = upper + source.stride();
    const int fx = places.fraction_x[i] & (kPlaceOne - 1);
    const int fy = places.fraction_y[i];
    const int above = upper[0] * kPlaceOne + (upper[1] - upper[0]) * fx;
    const int below = lower[0] * kPlaceOne + (lower[1] - lower[0]) * fx;
    const int mixed = above + round_shift((below - above) * fy, kPlaceFractionBits);
    out[i] = static_cast<std::uint8_t>(round_shift(mixed, kPlaceFractionBits));
  }
}

}  // namespace stof::dsp::ref
