#pragma once

#include <cmath>
#include <numbers>

#include "dsp/base/random.h"

namespace stof::host::test {

// Normally distributed numbers that are the same on every machine (Box and Muller).
class Gaussian {
 public:
  explicit Gaussian(std::uint64_t seed) : random_(seed) {}

  double uniform() { return (static_cast<double>(random_.next() >> 11U) + 0.5) * 0x1p-53; }
  double between(double low, double high) { return low + (high - low) * uniform(); }
  double next(double sigma) {
    const double radius = std::sqrt(-2 * std::log(uniform()));
    return sigma * radius * std::cos(2 * std::numbers::pi * uniform());
  }

 private:
  dsp::SplitMix64 random_;
};

}  // namespace stof::host::test
