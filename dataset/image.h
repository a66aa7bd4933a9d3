#pragma once

#include <cstddef>
#include <expected>
#include <string>
#include <vector>

#include "dsp/base/image.h"

namespace stof::dataset {

// One line: what is wrong, in which file, what to do about it.
struct Problem {
  std::string message;
};
template <typename T>
using Loaded = std::expected<T, Problem>;

template <typename T>
struct Image {
  int width = 0;
  int height = 0;
  std::vector<T> pixels;  // row by row

  Image() = default;
  Image(int w, int h, T fill = T{})
      : width(w),
        height(h),
        pixels(static_cast<std::size_t>(w) * static_cast<std::size_t>(h), fill) {}
  dsp::ImageView<const T> view() const { return {pixels.data(), width, height}; }
  dsp::ImageView<T> view() { return {pixels.data(), width, height}; }
};

}  // namespace stof::dataset
