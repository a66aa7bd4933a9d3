#include "host/picture/colour_scale.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

namespace stof::host {
namespace {

// OKLCH: lightness, chroma, hue in degrees.
struct Lch {
  double lightness;
  double chroma;
  double hue;
};

// Equally spaced from near to far: dark red, orange, yellow, green, cyan, blue, violet.
constexpr std::array<Lch, 8> kStops{{{0.42, 0.17, 22},
                                     {0.62, 0.21, 33},
                                     {0.77, 0.17, 68},
                                     {0.88, 0.17, 108},
                                     {0.80, 0.17, 155},
                                     {0.68, 0.12, 218},
                                     {0.50, 0.16, 268},
                                     {0.32, 0.13, 295}}};

std::uint8_t encode_srgb(double linear) {
  const double value = std::clamp(linear, 0.0, 1.0);
  const double encoded =
      value <= 0.0031308 ? 12.92 * value : 1.055 * std::pow(value, 1 / 2.4) - 0.055;
  return static_cast<std::uint8_t>(std::lround(255 * encoded));
}

// The definition of OKLab (B. Ottosson, 2020), sRGB primaries.
Rgb to_rgb(const Lch& colour) {
  const double angle = colour.hue * std::numbers::pi / 180;
  const double a = colour.chroma * std::cos(angle);
  const double b = colour.chroma * std::sin(angle);
  const double l = std::pow(colour.lightness + 0.3963377774 * a + 0.2158037573 * b, 3);
  const double m = std::pow(colour.lightness - 0.1055613458 * a - 0.0638541728 * b, 3);
  const double s = std::pow(colour.lightness - 0.0894841775 * a - 1.2914855480 * b, 3);
  return {encode_srgb(4.0767416621 * l - 3.3077115913 * m + 0.2309699292 * s),
          encode_srgb(-1.2684380046 * l + 2.6097574011 * m - 0.3413193965 * s),
          encode_srgb(-0.0041960863 * l - 0.7034186147 * m + 1.7076147010 * s)};
}

}  // namespace

Rgb scale_colour(double position) {
  constexpr double kSteps = kStops.size() - 1;
  const double at = std::clamp(position, 0.0, 1.0) * kSteps;
  const double step = std::min(std::floor(at), kSteps - 1);
  const std::size_t i = static_cast<std::size_t>(step);
  const double t = at - step;
  const Lch& from = kStops[i];
  const Lch& to = kStops[i + 1];
  return to_rgb({std::lerp(from.lightness, to.lightness, t), std::lerp(from.chroma, to.chroma, t),
                 std::lerp(from.hue, to.hue, t)});
}

double ColourScale::position(double depth_m) const {
  return std::clamp(std::log(depth_m / near_m) / std::log(far_m / near_m), 0.0, 1.0);
}

Rgb ColourScale::colour(double depth_m) const { return scale_colour(position(depth_m)); }

std::vector<double> ColourScale::ticks() const {
  constexpr double kRounding = 1e-9;
  std::vector<double> result;
  for (double decade = std::pow(10, std::floor(std::log10(near_m))); decade <= far_m;
       decade *= 10) {
    for (const double digit : {1.0, 1.5, 2.0, 3.0, 5.0, 7.0}) {
      const double distance = digit * decade;
      if (distance >= near_m * (1 - kRounding) && distance <= far_m * (1 + kRounding)) {
        result.push_back(distance);
      }
    }
  }
  constexpr std::size_t kEnough = 3;
  constexpr int kAbout = 8;
  return result.size() < kEnough ? round_ticks(near_m, far_m, kAbout) : result;
}

Rgb mixed(Rgb a, Rgb b, double share_of_b) {
  const auto mix = [share_of_b](std::uint8_t from, std::uint8_t to) {
    return static_cast<std::uint8_t>(std::lround(std::lerp(from, to, share_of_b)));
  };
  return {mix(a.red, b.red), mix(a.green, b.green), mix(a.blue, b.blue)};
}

std::vector<double> round_ticks(double low, double high, int count) {
  const double raw = (high - low) / std::max(count, 1);
  const double power = std::pow(10.0, std::floor(std::log10(raw)));
  double step = 10 * power;
  for (const double factor : {5.0, 2.0, 1.0}) {
    step = factor * power >= raw * (1 - 1e-9) ? factor * power : step;
  }
  std::vector<double> ticks;
  for (double n = std::ceil(low / step - 1e-9); n * step <= high + 1e-9 * step; n += 1) {
    ticks.push_back(n == 0 ? 0 : n * step);
  }
  return ticks;
}

}  // namespace stof::host
