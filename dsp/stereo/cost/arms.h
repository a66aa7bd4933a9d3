#pragma once

#include <cstdint>
#include <span>

#include "dsp/base/kernel.h"

// How far the surroundings of a pixel look like the pixel itself: the arms of its cross.
// Source: Zhang, Lu & Lafruit 2009, with the thresholds of their section III-A as parameters.
namespace stof::dsp {

inline constexpr int kMaxArm = 15;

struct ArmParams {
  int longest = 9;      // px, 1..kMaxArm
  int difference = 10;  // grey levels, 0..255
};

// left[x], right[x]: the longest run of columns x - 1, x - 2,  (x + 1, x + 2, ...) that differ
// from column x by at most `difference` each, at most `longest`; at least 1 where there is a
// column, 0 at the border of the image. Equal lengths, any length, any alignment, no overlap.
using ArmsAlong = void(std::span<const std::uint8_t> row, const ArmParams& params,
                       std::span<std::uint8_t> left, std::span<std::uint8_t> right) noexcept;

// The same up or down: `others` are the rows y - 1, y - 2,  (y + 1, y + 2, ...) inside the
// image, at most `longest` of them.
using ArmsAcross = void(std::span<const std::uint8_t> row,
                        std::span<const std::uint8_t* const> others, const ArmParams& params,
                        std::span<std::uint8_t> arms) noexcept;

STOF_KERNEL(ArmsAlong, arms_along, kAvx2)
STOF_KERNEL(ArmsAcross, arms_across, kAvx2)

// The columns [begin, end) of arms_along(), for vector variants.
void arms_along_columns(std::span<const std::uint8_t> row, const ArmParams& params,
                        std::size_t begin, std::size_t end, std::span<std::uint8_t> left,
                        std::span<std::uint8_t> right) noexcept;

}  // namespace stof::dsp
