#include "host/picture/rasteriser.h"

#include <algorithm>
#include <cmath>

namespace stof::host {

void Rasteriser::draw(const std::array<Corner, 3>& c) {
  const double area = (c[1].u - c[0].u) * (c[2].v - c[0].v) - (c[2].u - c[0].u) * (c[1].v - c[0].v);
  if (std::abs(area) < 1e-9) {
    return;
  }
  const auto [left, right] = std::minmax({c[0].u, c[1].u, c[2].u});
  const auto [top, bottom] = std::minmax({c[0].v, c[1].v, c[2].v});
  const int x_end = std::min(static_cast<int>(std::ceil(right)), colour_.width - 1);
  const int y_end = std::min(static_cast<int>(std::ceil(bottom)), colour_.height - 1);
  for (int y = std::max(static_cast<int>(top), 0); y <= y_end; ++y) {
    for (int x = std::max(static_cast<int>(left), 0); x <= x_end; ++x) {
      const double b = ((x - c[0].u) * (c[2].v - c[0].v) - (c[2].u - c[0].u) * (y - c[0].v)) / area;
      const double g = ((c[1].u - c[0].u) * (y - c[0].v) - (x - c[0].u) * (c[1].v - c[0].v)) / area;
      if (b >= 0 && g >= 0 && b + g <= 1) {
        put(x, y, c, {1 - b - g, b, g});
      }
    }
  }
}

void Rasteriser::put(int x, int y, const std::array<Corner, 3>& corners,
                     const std::array<double, 3>& shares) {
  double closeness = 0;
  Light light{};
  for (std::size_t i = 0; i < 3; ++i) {
    closeness += shares[i] * corners[i].closeness;
    for (std::size_t k = 0; k < light.size(); ++k) {
      light[k] += shares[i] * corners[i].light[k];
    }
  }
  float& nearest = closeness_.view().at(x, y);
  if (static_cast<float>(closeness) > nearest) {
    nearest = static_cast<float>(closeness);
    colour_.view().at(x, y) = light;
  }
}

dataset::Image<Rgb> Rasteriser::picture() const {
  constexpr Light kTop{0.165, 0.18, 0.21};
  constexpr Light kBottom{0.09, 0.1, 0.12};
  dataset::Image<Rgb> picture(colour_.width / kSamples, colour_.height / kSamples);
  for (int y = 0; y < picture.height; ++y) {
    for (int x = 0; x < picture.width; ++x) {
      Light sum{};
      for (int sample = 0; sample < kSamples * kSamples; ++sample) {
        const int sx = x * kSamples + sample % kSamples;
        const int sy = y * kSamples + sample / kSamples;
        const bool hit = closeness_.view().at(sx, sy) > 0;
        for (std::size_t k = 0; k < sum.size(); ++k) {
          sum[k] += hit ? colour_.view().at(sx, sy)[k]
                        : std::lerp(kTop[k], kBottom[k], static_cast<double>(y) / picture.height);
        }
      }
      const auto level = [&sum](std::size_t k) {
        return static_cast<std::uint8_t>(
            std::lround(255 * std::clamp(sum[k] / (kSamples * kSamples), 0.0, 1.0)));
      };
      picture.view().at(x, y) = {level(0), level(1), level(2)};
    }
  }
  return picture;
}

}  // namespace stof::host
