#pragma once

#include <cstddef>

#include "dsp/base/fixed.h"

namespace stof::dsp {

// Pixels begin .. end - 1 that have yet to be resolved, and the nearest matches before and behind.
struct OpenRun {
  std::size_t begin = 0;
  std::size_t end = 0;
  Disparity left;
  Disparity right;
  std::size_t left_at = 0;
  std::size_t right_at = 0;

  int to_left(std::size_t x) const noexcept { return static_cast<int>(x - left_at); }
  int to_right(std::size_t x) const noexcept { return static_cast<int>(right_at - x); }
};

}  // namespace stof::dsp
