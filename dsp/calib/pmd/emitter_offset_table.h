#pragma once

#include <cstdint>
#include <span>

#include "dsp/base/arena.h"
#include "dsp/calib/pmd_sensor.h"

namespace stof::dsp {

// The input of kernel emitter_offset (dsp/pmd/range/emitter_offset.h) for each pixel, row by row:
// width x height elements each. 0 everywhere for a pixel without a ray.
struct EmitterOffsetTable {
  std::span<std::int16_t> half_q2;
  std::span<std::int32_t> twice_area;
  std::span<std::int32_t> pole;
};

// For sensor.emitters (at least one), distances in 1 / units_per_metre.
//
// One light: exact at every distance. Several: what comes back from a light is weighted by
// cos^4(angle to the axis) / distance^2: a lobe that falls to half at 37 degrees, and a surface
// that faces the camera. With equal weights the correction of two lights would be worse than none,
// because the nearer one counts for up to three times the other. V and c' are fitted to 0.5 and
// 1.5 m.
//
// Two lights 12 cm to either side of a lens of 70 degrees, the largest error over the picture:
//   0.3 m 4 mm, from 0.5 m on below 0.6 mm; uncorrected 23, 20 mm, 13 mm at 1 m
//   lobes of cos^1 to cos^5 (60 to 30 degrees): below 6.5 mm from 0.5 m on
void fill_emitter_offset_table(const PmdSensor& sensor, double units_per_metre,
                               const EmitterOffsetTable& table) noexcept;
// The same in memory of an arena.
EmitterOffsetTable make_emitter_offset_table(const PmdSensor& sensor, double units_per_metre,
                                             Arena& arena) noexcept;

// The shortest way (twice a distance) that the table of this sensor is good for, same units.
std::uint32_t shortest_way(const PmdSensor& sensor, double units_per_metre) noexcept;

}  // namespace stof::dsp
