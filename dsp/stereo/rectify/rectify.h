#pragma once

#include <array>
#include <cstdint>
#include <span>

#include "dsp/base/image.h"
#include "dsp/base/kernel.h"

namespace stof::dsp {

// A place in a source picture has 7 fraction bits: two columns and two rows are mixed in 16 bits.
inline constexpr int kPlaceFractionBits = 7;
inline constexpr int kPlaceOne = 1 << kPlaceFractionBits;

// Where one pixel of an output row lies in the source: (x + fraction_x / 128, y + fraction_y /
// 128), with x + 1 and y + 1 inside the source too.
struct Place {
  std::uint16_t x = 0;
  std::uint16_t y = 0;
  std::uint8_t fraction_x = 0;  // below 128
  std::uint8_t fraction_y = 0;

  friend bool operator==(const Place&, const Place&) = default;
};

// Places of neighbouring pixels hardly bend: those of 32 x 32 pixels are two polynomials of third
// degree in each direction. A row of them has, for x and for y, four numbers
//   A, B, C, D = powers[0] + powers[1] t + powers[2] t^2 + powers[3] t^3,  t = (2 line - 31) / 32
// (float, added in this order; cut to whole numbers; 32768 too many in C and D), and pixel k of it
// lies (A + B k + C bend(k) + D twist(k)) >> 16 steps of 1/128 px from (x, y), clamped to low ..
// high.
inline constexpr int kPatchSide = 32;
inline constexpr int kPatchBias = 32768;
inline constexpr int kPatchFractionBits = 16;
constexpr int patch_bend(int k) noexcept {
  const int from_middle = 2 * k - (kPatchSide - 1);
  return (from_middle * from_middle - 1) / 2 - 240;
}
constexpr int patch_twist(int k) noexcept {
  const int from_middle = 2 * k - (kPatchSide - 1);
  return (from_middle * from_middle - 768) * from_middle / 32;
}

struct PlacePatch {
  std::array<std::array<float, 8>, 4> powers{};  // each: A B C D of x, A B C D of y
  std::uint16_t x = 0;
  std::uint16_t y = 0;
  std::array<std::int16_t, 2> low{};  // of x, of y
  std::array<std::int16_t, 2> high{};
  std::uint16_t wrong = 0;  // pixels whose places these are not
  bool serves = false;      // or the patch says nothing
};

// Writes one line, 0 .. 31, of a row of patches; skips the pixels of those that do not serve.
// Bilinear: each of both rows is a (128 - fx) + b fx, exact; their mixture by fy keeps 7 fraction
// bits, rounded; then it is rounded to whole grey levels, halves up. Within 0.51 grey levels of the
// exact value at the table's place. Source at least 2x2; out.size() in (32 (patches - 1), 32
// patches]; no overlap.
using RemapRow = void(ImageView<const std::uint8_t> source, std::span<const PlacePatch> patches,
                      int line, std::span<std::uint8_t> out) noexcept;
STOF_KERNEL(RemapRow, remap_row, kAvx2)

// One pixel of it. A line's numbers: A B C D of x, then of y, before they are cut.
std::array<float, 8> patch_line(const PlacePatch& patch, int line) noexcept;
Place place_of(const PlacePatch& patch, const std::array<float, 8>& numbers, int column) noexcept;
std::uint8_t mix(ImageView<const std::uint8_t> source, const Place& place) noexcept;

}  // namespace stof::dsp
