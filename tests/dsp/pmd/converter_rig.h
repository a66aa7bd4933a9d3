#pragma once

#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <numbers>
#include <vector>

#include "dsp/pmd/converter.h"
#include "tests/support/guarded_part.h"

namespace stof::dsp {

class ConverterRig {
 public:
  explicit ConverterRig(const PmdSensor& sensor)
      : converter_([&](Arena& arena) { return PmdConverter(sensor, arena); }) {}

  PmdConverter& converter() { return *converter_; }

 private:
  test::GuardedPart<PmdConverter> converter_;
};

// Four planes of samples of a sensor with dark 100, 12 bits unless said otherwise.
struct Planes {
  Planes(int w, int h) : width(w), height(h) {
    for (std::vector<std::uint16_t>& plane : planes) {
      plane.resize(static_cast<std::size_t>(w) * static_cast<std::size_t>(h));
    }
  }
  // A surface at distance_m; light and amplitude in LSB.
  void show(std::size_t pixel, double distance_m, double light, double amplitude,
            double modulation_hz = 20e6) {
    const double turn_m = 299792458.0 / (2 * modulation_hz);
    const double phi = distance_m / turn_m * 2 * std::numbers::pi;
    for (std::size_t k = 0; k < 4; ++k) {
      const double turned = phi + static_cast<double>(k) * std::numbers::pi / 2;
      const double value = std::round(100 + light + amplitude * std::cos(turned));
      planes[k][pixel] = static_cast<std::uint16_t>(std::min(std::max(value, 0.0), 4095.0));
    }
  }
  void show_everywhere(double distance_m, double light, double amplitude,
                       double modulation_hz = 20e6) {
    for (std::size_t i = 0; i < planes[0].size(); ++i) {
      show(i, distance_m, light, amplitude, modulation_hz);
    }
  }
  PmdSamples samples() const {
    const auto view = [this](std::size_t k) {
      return ImageView<const std::uint16_t>(planes[k].data(), width, height);
    };
    return {view(0), view(1), view(2), view(3)};
  }

  int width;
  int height;
  std::array<std::vector<std::uint16_t>, 4> planes;
};

}  // namespace stof::dsp
