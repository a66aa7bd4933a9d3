#include "hal/emu/imagery/noise.h"

#include <cmath>
#include <vector>

namespace stof::hal::emu {
namespace {

// exp(-y) for tiny y: the series ends below double's precision.
constexpr double exp_minus(double y) noexcept { return 1 - y + y * y / 2 - y * y * y / 6; }

// Integrates the bell curve outwards from 0 and notes where it passes each quantile. The curve
// comes from a recurrence, exp(-(x + h)^2 / 2) = exp(-x^2 / 2) * ratio(x), ratio(x + h) = ratio(x)
// q, so that no library's exp decides about bits.
std::array<std::int16_t, kGaussianSize> build() noexcept {
  constexpr double kStep = 1.0 / 512;
  constexpr int kSteps = 8 * 512;
  constexpr double kQ = exp_minus(kStep * kStep);
  std::vector<double> area(kSteps + 1, 0.0);
  double height = 1;
  double ratio = exp_minus(kStep * kStep / 2);
  for (std::size_t i = 0; i < kSteps; ++i) {
    const double next = height * ratio;
    area[i + 1] = area[i] + (height + next) / 2;
    height = next;
    ratio *= kQ;
  }
  std::array<std::int16_t, kGaussianSize> table{};
  constexpr std::size_t kHalf = kGaussianSize / 2;
  std::size_t at = 0;
  for (std::size_t i = 0; i < kHalf; ++i) {
    const double wanted = area.back() * (static_cast<double>(i) + 0.5) / kHalf;
    while (area[at + 1] < wanted) {
      ++at;
    }
    const double inside = (wanted - area[at]) / (area[at + 1] - area[at]);
    const double quantile = (static_cast<double>(at) + inside) * kStep * (1 << kGaussianBits);
    const std::int16_t value = static_cast<std::int16_t>(std::floor(quantile + 0.5));
    table[kHalf + i] = value;
    table[kHalf - 1 - i] = static_cast<std::int16_t>(-value);
  }
  return table;
}

}  // namespace

const std::array<std::int16_t, kGaussianSize>& gaussian_table() noexcept {
  static const std::array<std::int16_t, kGaussianSize> table = build();
  return table;
}

}  // namespace stof::hal::emu
