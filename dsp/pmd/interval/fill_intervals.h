#pragma once

#include "dsp/base/image.h"
#include "dsp/pmd/interval/interval.h"
#include "dsp/pmd/pmd_maps.h"

namespace stof::dsp {

// Row y of what intervals are made of, and the rows beside it.
IntervalRows located_rows(const PmdMaps& maps, int y) noexcept;

// Fills smoothed and smoothed_sigma, where they are there, from distance and sigma: kernel
// `average_pairs`. The first and the last row are copied, having no opposite neighbours.
void smooth_readings(const PmdMaps& maps) noexcept;

// low and high of some rows from what smooth_readings() made (distance and sigma where there is
// none of it), maps.range and maps.widest: kernel `interval`. Judges pixels that have a distance,
// and of their flags only kPmdEdge, kPmdOutOfRange and kPmdWrapped, which are set or taken back;
// others keep their flags and have low = high = 0. Neither distance nor sigma changes, so rows can
// be split in any way.
//
// To add whole ranges to readings (distance += k * maps.range), do it after PmdConverter::measure()
// and before smooth_readings(), in any pixels, and in long_distance where it is there. Readings
// beyond maps.range count as moved: they are not out of range.
void fill_intervals(const PmdMaps& maps, Rows rows) noexcept;

// A wrapped pixel carries no distance: distance, sigma, smoothed, smoothed_sigma and long_distance
// are 0 where flags has kPmdWrapped; what was read is kept in folded, but for kPmdEdge of fine
// pixels. After
// fill_intervals() of all rows, because neighbours are judged by them.
void drop_wrapped(const PmdMaps& maps) noexcept;

// All three for the whole picture. May be called again after distances have changed, or flags of
// pixels whose distance was set to 0; pixels that were dropped before stay dropped, and their
// neighbours are then judged without them.
void refresh_intervals(const PmdMaps& maps) noexcept;

}  // namespace stof::dsp
