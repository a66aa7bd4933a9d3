#include "dsp/calib/stereo/interval_tables.h"

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <span>

#include "dsp/base/index.h"
#include "dsp/calib/stereo/column_tables.h"
#include "dsp/calib/stereo/disparity_table.h"

namespace stof::dsp {

IntervalTables make_interval_tables(const StereoRig& rig, int min_disparity, int disparities,
                                    int width, QuarterMm max_range, Arena& arena) noexcept {
  constexpr int kLargest = 32767;
  const int steps = (disparities + 1) * Disparity::kOne;
  const int first = std::max((min_disparity - 1) * Disparity::kOne, -kLargest);
  IntervalTables tables{.converging = rig.converging.has_value(), .columns = {}, .disparity = {}};
  if (tables.converging) {
    const int last = std::min(first + steps, kLargest);
    const std::span<std::int32_t> left = arena.take<std::int32_t>(index(width));
    const std::span<std::int32_t> right =
        arena.take<std::int32_t>(right_tangents(left.size(), first, last));
    if (!arena.is_measuring()) {
      tables.columns = make_column_tables(rig, static_cast<std::int16_t>(first),
                                          static_cast<std::int16_t>(last), max_range, left, right);
    }
    return tables;
  }
  const std::span<DepthInterval> bounds =
      arena.take<DepthInterval>(index(steps + 1 + 2 * kMostHalfWidth));
  if (!arena.is_measuring()) {
    tables.disparity =
        make_disparity_table(rig, static_cast<std::int16_t>(first), max_range, bounds);
  }
  return tables;
}

}  // namespace stof::dsp
