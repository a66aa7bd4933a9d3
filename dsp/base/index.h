#pragma once

#include <cstddef>

namespace stof::dsp {

// A count or a place that is an int, as spans and arrays want it. Not negative.
constexpr std::size_t index(int value) noexcept { return static_cast<std::size_t>(value); }

constexpr std::size_t pixel_count(int width, int height) noexcept {
  return index(width) * index(height);
}

}  // namespace stof::dsp
