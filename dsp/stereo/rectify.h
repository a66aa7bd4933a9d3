#pragma once

#include <cstdint>
#include <span>

#include "dsp/base/image.h"
#include "dsp/base/target.h"

namespace stof::dsp {

// A place in a source picture has 7 fraction bits: two columns and two rows are mixed in 16 bits.
inline constexpr int kPlaceFractionBits = 7;
inline constexpr int kPlaceOne = 1 << kPlaceFractionBits;
// In the high bit of fraction_x: the place is what the pixel sees. Without it the pixel lies
// outside of the source, and the place is the nearest one inside: borders replicate.
inline constexpr std::uint8_t kPlaceInside = 0x80;

// Where each pixel of an output row lies in the source: (x + fraction_x / 128, y + fraction_y /
// 128), with x + 1 and y + 1 inside the source too. 6 bytes a pixel. The high bit of fraction_y is
// 0.
struct RemapRow {
  std::span<const std::uint16_t> x;
  std::span<const std::uint16_t> y;
  std::span<const std::uint8_t> fraction_x;
  std::span<const std::uint8_t> fraction_y;
};

// Bilinear: each of both rows is a (128 - fx) + b fx, exact; their mixture by fy keeps 7 fraction
// bits, rounded; then it is rounded to whole grey levels, halves up. Within 0.51 grey levels of the
// exact value at the table's place. Source at least 2x2; spans of one length, any alignment, no
// overlap.
using RemapRowKernel = void(ImageView<const std::uint8_t> source, const RemapRow& places,
                            std::span<std::uint8_t> out) noexcept;
namespace ref {
RemapRowKernel remap_row;
}
namespace neon {
RemapRowKernel remap_row;
}

}  // namespace stof::dsp
