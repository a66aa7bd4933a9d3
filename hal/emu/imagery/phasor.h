#pragma once

#include <array>
#include <cmath>
#include <numbers>

namespace stof::hal::emu {

struct Phasor {
  double re = 0;
  double im = 0;

  friend constexpr Phasor operator+(const Phasor& a, const Phasor& b) noexcept {
    return {a.re + b.re, a.im + b.im};
  }
  friend constexpr Phasor operator*(const Phasor& a, const Phasor& b) noexcept {
    return {a.re * b.re - a.im * b.im, a.re * b.im + a.im * b.re};
  }
  friend constexpr Phasor operator*(double s, const Phasor& a) noexcept {
    return {s * a.re, s * a.im};
  }
  constexpr Phasor conjugate() const noexcept { return {re, -im}; }
};

// e^(2 pi j turns), to 1e-13: Taylor series within an eighth of a turn, so that every machine gets
// the same bits.
inline Phasor phasor(double turns) noexcept {
  const double quarters = std::floor(4 * turns + 0.5);
  const double x = (turns - quarters / 4) * 2 * std::numbers::pi;
  const double y = x * x;
  const double cosine =
      1 -
      y / 2 *
          (1 - y / 12 * (1 - y / 30 * (1 - y / 56 * (1 - y / 90 * (1 - y / 132 * (1 - y / 182))))));
  const double sine =
      x * (1 - y / 6 * (1 - y / 20 * (1 - y / 42 * (1 - y / 72 * (1 - y / 110 * (1 - y / 156))))));
  const double turn = quarters - 4 * std::floor(quarters / 4);
  if (turn < 0.5) {
    return {cosine, sine};
  }
  if (turn < 1.5) {
    return {-sine, cosine};
  }
  return turn < 2.5 ? Phasor{-cosine, -sine} : Phasor{sine, -cosine};
}

}  // namespace stof::hal::emu
