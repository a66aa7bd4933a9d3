#include "dsp/calib/remap_table.h"

#include <algorithm>
#include <cmath>

#include "dsp/base/check.h"

namespace stof::dsp {
namespace {

// 1/128 px; never on the last of `size` pixels, which has no neighbour.
int to_fixed(double place, int size) noexcept {
  return std::min(static_cast<int>(std::lround(place * kPlaceOne)), (size - 1) * kPlaceOne - 1);
}

}  // namespace

void fill_remap_table(const SourceMap& map, const RemapTable& table) noexcept {
  const Pinhole& raw = map.raw();
  STOF_CHECK(raw.width >= 2 && raw.height >= 2 && raw.width <= 65536 && raw.height <= 65536);
  STOF_CHECK(table.x.width() == map.rectified().width &&
             table.x.height() == map.rectified().height);
  STOF_CHECK(same_size(table.x, table.y) && same_size(table.x, table.fraction_x) &&
             same_size(table.x, table.fraction_y));
  for (int v = 0; v < table.x.height(); ++v) {
    for (int u = 0; u < table.x.width(); ++u) {
      const SourceMap::Place place = map.at(u, v);
      const int x = to_fixed(place.u, raw.width);
      const int y = to_fixed(place.v, raw.height);
      table.x.at(u, v) = static_cast<std::uint16_t>(x / kPlaceOne);
      table.y.at(u, v) = static_cast<std::uint16_t>(y / kPlaceOne);
      table.fraction_x.at(u, v) =
          static_cast<std::uint8_t>(x % kPlaceOne + (place.inside ? kPlaceInside : 0));
      table.fraction_y.at(u, v) = static_cast<std::uint8_t>(y % kPlaceOne);
    }
  }
}

}  // namespace stof::dsp
