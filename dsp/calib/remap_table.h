#pragma once

#include <cstdint>

#include "dsp/base/image.h"
#include "dsp/calib/rectification.h"
#include "dsp/stereo/rectify.h"

namespace stof::dsp {

// The places of all pixels of a rectified picture; see RemapRow.
struct RemapTable {
  ImageView<std::uint16_t> x;
  ImageView<std::uint16_t> y;
  ImageView<std::uint8_t> fraction_x;
  ImageView<std::uint8_t> fraction_y;

  RemapRow row(int line) const noexcept {
    return {x.row(line), y.row(line), fraction_x.row(line), fraction_y.row(line)};
  }
};

// Writes all of `table`, whose images have the size of map.rectified(). Places are rounded to the
// nearest 1/128 px; a place on the last column or row of the source counts as 1/128 px before it.
// map.raw() is at least 2x2 and at most 65536 pixels wide and high.
void fill_remap_table(const SourceMap& map, const RemapTable& table) noexcept;

}  // namespace stof::dsp
