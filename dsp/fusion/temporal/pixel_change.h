#pragma once

#include <cstdint>
#include <span>

#include "dsp/base/kernel.h"

namespace stof::dsp {

// A pixel has changed by more grey levels than that: 4 sigma of the difference of two pictures with
// a noise of 2 each, so that one of 9 pixels exceeds it by chance in fewer than one frame in a
// thousand.
inline constexpr int kPixelStep = 12;

// changed[x] = 255 where |now[x] - then[x]| > kPixelStep, else 0; then[x] = now[x] where it has.
// Equal lengths, any length, any alignment; no overlap.
using PixelChange = void(std::span<const std::uint8_t> now, std::span<std::uint8_t> then,
                         std::span<std::uint8_t> changed) noexcept;
STOF_KERNEL(PixelChange, pixel_change, kNeon)

}  // namespace stof::dsp
