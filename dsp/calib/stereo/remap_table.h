#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

#include "dsp/base/arena.h"
#include "dsp/base/image.h"
#include "dsp/base/index.h"
#include "dsp/calib/stereo/rectification.h"
#include "dsp/stereo/rectify/rectify.h"

namespace stof::dsp {

// Where all pixels of a rectified picture lie in the raw one, to the nearest 1/128 px, in 0.4 bytes
// a pixel: polynomials for patches of 32 x 32 pixels (rectify.h), and the places of those pixels,
// one in some hundred, for which a polynomial is 1/128 px off. A patch with too many of them (edges
// of what a lens can see; lenses that bend more than any we know) is computed anew each time: exact
// too, and some ten times slower.
class RemapTable {
 public:
  // map.raw() is at least 2x2 and at most 65536 pixels wide and high.
  RemapTable(const SourceMap& map, Arena& arena) noexcept;

  // The row's pixels of the rectified picture. source: map.raw()'s size; out: the picture's width.
  // A place on the last column or row of the source counts as 1/128 px before it.
  void remap(ImageView<const std::uint8_t> source, int row,
             std::span<std::uint8_t> out) const noexcept;

  // The place that a pixel is interpolated from.
  Place place(int column, int row) const noexcept;

  // The pixels of a row that the camera saw lie within [begin, end). Not all of it if `torn`; then
  // inside() tells.
  struct Seen {
    std::int32_t begin = 0;
    std::int32_t end = 0;
    bool torn = false;
  };
  Seen seen(int row) const noexcept { return seen_[index(row)]; }
  bool inside(int column, int row) const noexcept;

  // Patches that are computed anew each time.
  int computed_patches() const noexcept;

 private:
  // A pixel of a row whose patch does not tell its place.
  struct Exception {
    std::uint16_t column = 0;
    Place place;
  };
  static_assert(sizeof(Exception) == 8);

  std::span<PlacePatch> patches_of(int row) const noexcept;
  std::span<const Exception> exceptions_of(int row) const noexcept;
  void fit() noexcept;
  void choose() noexcept;
  void list() noexcept;

  SourceMap map_;
  std::size_t columns_;  // of patches
  std::span<PlacePatch> patches_;
  std::span<Exception> exceptions_;
  std::span<std::uint32_t> ends_;  // in exceptions_, of each row
  std::span<Seen> seen_;
};

}  // namespace stof::dsp
