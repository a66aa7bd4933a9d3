#pragma once

#include <array>
#include <cstdint>

#include "dsp/base/image.h"

namespace stof::dsp {

// One grey value for each grey value.
using GreyTable = std::array<std::uint8_t, 256>;

// The table that brings `picture` to the mean and the standard deviation of `model`, for cameras
// whose exposure, gain or gamma differ: round(mean_m + gain (v - mean_p)), clamped to 0..255, gain
// = deviation_m / deviation_p within 1/4..4. The table of identity where either is flat or empty.
GreyTable equalising_table(ImageView<const std::uint8_t> picture,
                           ImageView<const std::uint8_t> model) noexcept;

// out = table[picture], pixel by pixel, for these rows. Equal sizes; out may be picture.
void apply_table(const GreyTable& table, ImageView<const std::uint8_t> picture, Rows rows,
                 ImageView<std::uint8_t> out) noexcept;

}  // namespace stof::dsp
