#pragma once

#include <array>

#include "host/picture/png.h"

namespace stof::host {

// The light of a surface towards the eye: red, green, blue, 0..1.
using Light = std::array<double, 3>;

// A corner of a triangle on the screen.
struct Corner {
  double u = 0;          // samples to the right
  double v = 0;          // samples down
  double closeness = 0;  // 1 / distance, above 0
  Light light{};
};

// A picture made of triangles with a z-buffer; each pixel is the mean of kSamples^2 samples.
class Rasteriser {
 public:
  static constexpr int kSamples = 2;

  // In samples, multiples of kSamples.
  Rasteriser(int width, int height) : colour_(width, height), closeness_(width, height, 0.0F) {}

  // Both sides are visible; what lies outside the screen is cut.
  void draw(const std::array<Corner, 3>& corners);
  // Over a background that darkens downwards.
  dataset::Image<Rgb> picture() const;

 private:
  void put(int x, int y, const std::array<Corner, 3>& corners, const std::array<double, 3>& shares);

  dataset::Image<Light> colour_;
  dataset::Image<float> closeness_;
};

}  // namespace stof::host
