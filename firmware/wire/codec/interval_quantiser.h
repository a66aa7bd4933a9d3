#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

#include "dsp/base/fixed.h"
#include "dsp/fusion/depth_map.h"

// Depth rounded as far as its interval does not care, and intervals that grow by as much: what lay
// in one before lies in it afterwards. Each band of rows has a scale s; values become multiples of
// 1 << s and travel as what they are in this unit.
namespace stof::wire {

inline constexpr int kFitRows = 8;  // of a band; the last one may have fewer
inline constexpr int kMostFitScale = 5;
// A step is at most this part of the intervals' widths, but for one pixel of kFitNarrow.
inline constexpr unsigned kFitPart = 8;
inline constexpr unsigned kFitNarrow = 256;
// Wider than this there is no room to grow by what rounding may move: 3 << kMostFitScale.
inline constexpr unsigned kMostFitWidth = 65'535 - (3U << kMostFitScale);

constexpr std::size_t fit_bands(int height) noexcept {
  return (static_cast<std::size_t>(height) + kFitRows - 1) / kFitRows;
}

// Scale of the band that begins at row `first`: the largest one, at most kMostFitScale, whose step
// suits the widths of its pixels with depth; 0 where none has, or any width is above kMostFitWidth.
// Both images of the map have one size.
std::uint8_t fit_scale(const dsp::DepthMap& map, int first) noexcept;

// In units of 1 << scale, of rows equally long. Depth: the nearest multiple (halves up), none stays
// none, any other one is at least 1 and at most the largest that fits 16 bits.
void fit_depth(std::span<const dsp::QuarterMm> depth, unsigned scale,
               std::span<std::uint16_t> out) noexcept;
// Width: grown by twice what fit_depth() moves this depth, in quarter millimetres; widths are at
// most kMostFitWidth, or scale is 0.
void grow_width(std::span<const dsp::QuarterMm> depth, std::span<const dsp::QuarterMm> width,
                unsigned scale, std::span<std::uint16_t> out) noexcept;
// In place: rounded up to the next multiple, in units of it.
void fit_width(std::span<std::uint16_t> width, unsigned scale) noexcept;

}  // namespace stof::wire
