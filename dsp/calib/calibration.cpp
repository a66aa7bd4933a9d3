#include "dsp/calib/calibration.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace stof::dsp {
namespace {

bool finite_positive(double value) noexcept { return std::isfinite(value) && value > 0; }

bool usable(const Pinhole& lens) noexcept {
  return lens.width > 0 && lens.height > 0 && finite_positive(lens.fx) &&
         finite_positive(lens.fy) && std::isfinite(lens.cx) && std::isfinite(lens.cy) &&
         std::isfinite(lens.k1) && std::isfinite(lens.k2);
}

bool orthonormal(const std::array<double, 9>& r) noexcept {
  for (std::size_t i = 0; i < 3; ++i) {
    for (std::size_t j = 0; j < 3; ++j) {
      const double dot =
          r[3 * i] * r[3 * j] + r[3 * i + 1] * r[3 * j + 1] + r[3 * i + 2] * r[3 * j + 2];
      if (!(std::abs(dot - (i == j ? 1.0 : 0.0)) <= 1e-3)) {
        return false;
      }
    }
  }
  return true;
}

const char* pmd_problem(const PmdSensor& pmd) noexcept {
  if (!usable(pmd.lens)) {
    return "the PMD lens has a size, focal length or centre that is not usable";
  }
  // The distance of one turn must fit u16 quarter millimetres: 9.15 MHz and up.
  if (pmd.modulation.value < 9'150'000 || pmd.modulation.value > 200'000'000) {
    return "the PMD modulation frequency is outside 9.15 to 200 MHz";
  }
  if (!finite_positive(pmd.electrons_per_lsb) || !(pmd.noise_lsb >= 0) ||
      !std::isfinite(pmd.noise_lsb) || !(pmd.dark_lsb >= 0) || !(pmd.dark_lsb < 32768) ||
      !(pmd.min_modulation_ratio >= 0) || !(pmd.min_modulation_ratio <= 1) ||
      !(pmd.suppressed_lsb >= 0) || !std::isfinite(pmd.suppressed_lsb) ||
      !finite_positive(pmd.asymmetry_sigmas) || !std::isfinite(pmd.offset_m)) {
    return "a PMD constant (dark, noise, gain, ratio or offset) is not usable";
  }
  const std::size_t pixels =
      static_cast<std::size_t>(pmd.lens.width) * static_cast<std::size_t>(pmd.lens.height);
  if (!pmd.fixed_pattern.empty() && pmd.fixed_pattern.size() != pixels) {
    return "the PMD fixed pattern does not have the sensor's size";
  }
  return "";
}

}  // namespace

WigglingTable fourth_harmonic_table(double amplitude_rad) noexcept {
  constexpr double kTurn = 2 * std::numbers::pi;
  WigglingTable table{};
  for (int i = 0; i < kWigglingSteps; ++i) {
    const double wiggle = amplitude_rad * std::sin(4 * kTurn * i / kWigglingSteps);
    table[static_cast<std::size_t>(i)] =
        static_cast<std::int16_t>(std::lround(wiggle / kTurn * 65536));
  }
  return table;
}

const char* problem(const Calibration& calibration) noexcept {
  if (!usable(calibration.stereo.left)) {
    return "the left camera has a size, focal length or centre that is not usable";
  }
  if (!finite_positive(calibration.stereo.baseline_m) ||
      !std::isfinite(calibration.stereo.doff_px)) {
    return "the baseline or the disparity offset is not usable";
  }
  const Pinhole& pmd = calibration.pmd.lens;
  if (pmd.width == 0 && pmd.height == 0) {
    return "";  // stereo only
  }
  if (!orthonormal(calibration.pmd_to_stereo.rotation)) {
    return "the rotation from PMD to stereo is not orthonormal";
  }
  if (!std::ranges::all_of(calibration.pmd_to_stereo.translation_m,
                           [](double t) { return std::abs(t) < 100; })) {
    return "the translation from PMD to stereo is not usable";
  }
  return pmd_problem(calibration.pmd);
}

}  // namespace stof::dsp
