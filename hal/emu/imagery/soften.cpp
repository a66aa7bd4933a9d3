#include "hal/emu/imagery/soften.h"

#include <algorithm>
#include <cmath>
#include <span>
#include <vector>

#include "hal/emu/imagery/grey.h"

namespace stof::hal::emu {
namespace {

constexpr double kGaussianReach = 4;  // standard deviations

std::uint16_t rounded(double value) noexcept {
  return static_cast<std::uint16_t>(std::clamp(std::floor(value + 0.5), 0.0, 65535.0));
}

// Weights of the places -reach .. reach of a bell of that width, whose sum is 1.
std::vector<double> weights_of(double width, int reach) {
  std::vector<double> out;
  double sum = 0;
  for (int i = -reach; i <= reach; ++i) {
    out.push_back(bell(i, width));
    sum += out.back();
  }
  for (double& weight : out) {
    weight /= sum;
  }
  return out;
}

double variance_of(const std::vector<double>& weights, int reach) noexcept {
  double sum = 0;
  for (int i = -reach; i <= reach; ++i) {
    sum += weights[static_cast<std::size_t>(i + reach)] * i * i;
  }
  return sum;
}

// Weights whose variance is sigma^2: that of a bell which is sampled and cut off is another.
std::vector<double> weights_with_variance(double sigma, int reach) {
  constexpr int kHalvings = 50;
  double low = 0.05;  // of the bell's width
  double high = 4 * sigma + 1;
  for (int i = 0; i < kHalvings; ++i) {
    const double middle = (low + high) / 2;
    const bool narrow = variance_of(weights_of(middle, reach), reach) < sigma * sigma;
    (narrow ? low : high) = middle;
  }
  return weights_of(low, reach);
}

void blur(double sigma, dataset::Image<std::uint16_t>& picture) {
  const int reach = reach_of(sigma);
  const std::vector<double> weights = weights_with_variance(sigma, reach);
  dataset::Image<double> along(picture.width, picture.height);
  for (int y = 0; y < picture.height; ++y) {
    for (int x = 0; x < picture.width; ++x) {
      double sum = 0;
      for (int i = -reach; i <= reach; ++i) {
        sum += weights[static_cast<std::size_t>(i + reach)] *
               picture.view().at(std::clamp(x + i, 0, picture.width - 1), y);
      }
      along.view().at(x, y) = sum;
    }
  }
  std::vector<double> sums(static_cast<std::size_t>(picture.width));
  for (int y = 0; y < picture.height; ++y) {
    std::ranges::fill(sums, 0.0);
    for (int i = -reach; i <= reach; ++i) {
      const std::span<const double> row =
          along.view().row(std::clamp(y + i, 0, picture.height - 1));
      const double weight = weights[static_cast<std::size_t>(i + reach)];
      for (std::size_t x = 0; x < sums.size(); ++x) {
        sums[x] += weight * row[x];
      }
    }
    std::ranges::transform(sums, picture.view().row(y).begin(), rounded);
  }
}

void darken(double vignetting, double black, dataset::Image<std::uint16_t>& picture) {
  const double middle_x = (picture.width - 1) / 2.0;
  const double middle_y = (picture.height - 1) / 2.0;
  const double corner = middle_x * middle_x + middle_y * middle_y;
  const double level = black * (1 << kGreyBits);
  for (int y = 0; y < picture.height; ++y) {
    for (int x = 0; x < picture.width; ++x) {
      const double dx = x - middle_x;
      const double dy = y - middle_y;
      const double kept = 1 - vignetting * (dx * dx + dy * dy) / corner;
      std::uint16_t& value = picture.view().at(x, y);
      value = rounded(level + kept * (value - level));
    }
  }
}

}  // namespace

double bell(double x, double sigma) noexcept {
  const double y = x * x / (2 * sigma * sigma);
  if (!(y < 700)) {
    return 0;
  }
  constexpr int kHalvings = 12;  // the series begins at y / 4096, and is squared as often
  const double t = y / (1 << kHalvings);
  double value = 1 - t * (1 - t / 2 * (1 - t / 3 * (1 - t / 4 * (1 - t / 5 * (1 - t / 6)))));
  for (int i = 0; i < kHalvings; ++i) {
    value *= value;
  }
  return value;
}

double blurred_pixel(double x, double sigma) noexcept {
  constexpr int kParts = 16;
  double sum = 0;
  for (int i = 0; i < kParts; ++i) {
    sum += bell(x + (i + 0.5) / kParts - 0.5, sigma);
  }
  return sum / kParts;
}

int reach_of(double blur_px) noexcept {
  return static_cast<int>(std::ceil(kGaussianReach * blur_px));
}

void soften(const LensQuality& lens, double black, dataset::Image<std::uint16_t>& picture) {
  if (lens.blur_px > 0) {
    blur(lens.blur_px, picture);
  }
  if (lens.vignetting > 0) {
    darken(lens.vignetting, black, picture);
  }
}

}  // namespace stof::hal::emu
