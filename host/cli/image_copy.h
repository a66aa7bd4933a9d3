#pragma once

#include <algorithm>
#include <type_traits>

#include "dataset/image.h"
#include "dsp/base/image.h"

namespace stof::host {

// The pixels of a view that outlive what it looks at.
template <typename T>
dataset::Image<std::remove_const_t<T>> copy_of(const dsp::ImageView<T>& picture) {
  dataset::Image<std::remove_const_t<T>> copy(picture.width(), picture.height());
  for (int y = 0; y < copy.height; ++y) {
    std::ranges::copy(picture.row(y), copy.view().row(y).begin());
  }
  return copy;
}

}  // namespace stof::host
