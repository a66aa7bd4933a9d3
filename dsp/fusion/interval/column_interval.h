#pragma once

#include <cstdint>
#include <span>

#include "dsp/base/fixed.h"
#include "dsp/base/kernel.h"
#include "dsp/fusion/interval/stereo_interval.h"

namespace stof::dsp {

// Tangents of the rays of columns: i32 with 28 fraction bits, -4 < T < 4.
inline constexpr int kTangentBits = 28;
// In place of a tangent: no ray (see dsp/calib/stereo/column_tables.h). Less than any T_r, more
// than any T_l, so that the difference is not positive and there is no depth.
inline constexpr std::int32_t kNoRightRay = -(std::int32_t{1} << 30);
inline constexpr std::int32_t kNoLeftRay = std::int32_t{1} << 30;

// Z = b / (T_r[x_r] - T_l[x_l]) for pictures whose axes converge; x_l is the column of the pixel,
// x_r = x_l - d in 1/16 px. The tables are exact to half a unit.
struct ColumnTables {
  std::int16_t first_raw = 0;  // disparities outside of first_raw .. last_raw have no interval
  std::int16_t last_raw = 0;
  QuarterMm max_range = 0;                  // where a far end ends
  std::int64_t near_numerator = 0;          // b in quarter mm with 28 fraction bits, rounded down,
  std::int64_t far_numerator = 0;           // and rounded up; 2^30 .. 2^60
  std::span<const std::int32_t> left = {};  // T_l of each column
  std::span<const std::int32_t> right =
      {};  // element k: T_r of column (k - last_raw - kMostHalfWidth) / 16
};

// Elements of `right` for a row of so many columns.
constexpr std::size_t right_tangents(std::size_t columns, int first_raw, int last_raw) noexcept {
  return columns * Disparity::kOne + static_cast<std::size_t>(last_raw - first_raw) +
         2 * std::size_t{kMostHalfWidth};
}

// Interval of each disparity, quarter mm, half[x] being 2 sigma in 1/16 px:
// low[x] = floor(b / (T_r[x - d - 2 sigma] - T_l[x])), at least 1,
// high[x] = ceil(b / (T_r[x - d + 2 sigma] - T_l[x])). Both differences are taken one unit
// towards the outside, so that what the tables were rounded by cannot make the interval shorter: it
// holds [Z(d + 2 sigma), Z(d - 2 sigma)], and ends at most 1 + Z^2 / (b 2^27) quarter mm outside of
// it. A far end beyond max_range, at infinity or behind it is max_range. 0, 0 where the near end is
// there too, without disparity and for one outside of the tables.
// Columns, left, low and high of equal length, right as above; any alignment, no overlap.
using ColumnInterval = void(std::span<const Disparity> disparity,
                            std::span<const std::uint8_t> half, const ColumnTables& tables,
                            std::span<QuarterMm> low, std::span<QuarterMm> high) noexcept;
STOF_KERNEL(ColumnInterval, column_interval, kNeon)
namespace ref {
// The same for one pixel in column x; half in 0 .. kMostHalfWidth.
DepthInterval column_interval_at(std::size_t x, int raw, int half,
                                 const ColumnTables& tables) noexcept;
}  // namespace ref

}  // namespace stof::dsp
