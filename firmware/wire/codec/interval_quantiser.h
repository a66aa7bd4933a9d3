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

inline constexpr int kQuantiserRows = 8;  // of a band; the last one may have fewer
inline constexpr int kMostQuantiserScale = 5;
// A step is at most this part of the intervals' widths, but for one pixel of kQuantiserNarrow.
inline constexpr unsigned kQuantiserPart = 8;
inline constexpr unsigned kQuantiserNarrow = 256;
// Wider than this there is no room to grow by what rounding may move: 3 << kMostQuantiserScale.
inline constexpr unsigned kMostQuantisedWidth = 65'535 - (3U << kMostQuantiserScale);

constexpr std::size_t quantiser_bands(int height) noexcept {
  return (static_cast<std::size_t>(height) + kQuantiserRows - 1) / kQuantiserRows;
}

// Scale of the band that begins at row `first`: the largest one, at most kMostQuantiserScale, whose
// step suits the widths of its pixels with depth; 0 where none has, or any width is above
// kMostQuantisedWidth. Both images of the map have one size.
std::uint8_t quantiser_scale(const dsp::DepthMap& map, int first) noexcept;

// In units of 1 << scale, of rows equally long. Depth: the nearest multiple (halves up), none stays
// none, any other one is at least 1 and at most the largest that fits 16 bits.
void quantise_depth(std::span<const dsp::QuarterMm> depth, unsigned scale,
                    std::span<std::uint16_t> out) noexcept;
// Width: grown by twice what quantise_depth() moves this depth, in quarter millimetres; widths are
// at most kMostQuantisedWidth, or scale is 0.
void grow_width(std::span<const dsp::QuarterMm> depth, std::span<const dsp::QuarterMm> width,
                unsigned scale, std::span<std::uint16_t> out) noexcept;
// In place: rounded up to the next multiple, in units of it.
void quantise_width(std::span<std::uint16_t> width, unsigned scale) noexcept;

}  // namespace stof::wire
