#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

#include "dsp/base/target.h"

// Census descriptors of one row: a bit for every neighbour in a window, set where the neighbour is
// darker than the centre. Borders replicate. Source: Zabih & Woodfill 1994.
//
// Bits are numbered along the rows of the window from its top left neighbour, the centre left out:
// 0..23 in 5x5, 0..61 in 9x7 (9 columns, 7 rows).
//
// Layout: planes[p][x], p-th byte of all columns beside each other: bit b is place b % kPlaneBits
// of plane b / kPlaneBits; places beyond the last bit are 0. Sixteen candidates of a plane are one
// vector, which is what hamming.h wants.
namespace stof::dsp {

inline constexpr int kCensus5x5Bits = 24;
inline constexpr int kCensus9x7Bits = 62;

// Planes of a descriptor of so many bits.
constexpr std::size_t planes_of(int bits) noexcept {
  return static_cast<std::size_t>((bits + kPlaneBits - 1) / kPlaneBits);
}

// rows: the window's rows from top to bottom, the middle one being described; n columns each, any
// length, any alignment. planes: planes_of(bits) * n bytes, overlapping no row.
template <std::size_t kRows>
using Census = void(std::span<const std::span<const std::uint8_t>, kRows> rows,
                    std::span<std::uint8_t> planes) noexcept;

namespace ref {
Census<5> census_5x5;
Census<7> census_9x7;
}  // namespace ref
namespace neon {
Census<5> census_5x5;
Census<7> census_9x7;
}  // namespace neon
namespace avx2 {
Census<5> census_5x5;
Census<7> census_9x7;
}  // namespace avx2
namespace best {
inline constexpr Kernel<Census<5>> census_5x5{STOF_VARIANTS(census_5x5)};
inline constexpr Kernel<Census<7>> census_9x7{STOF_VARIANTS(census_9x7)};
}  // namespace best

}  // namespace stof::dsp
