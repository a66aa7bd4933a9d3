#include "dsp/calib/calibration.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "dsp/base/index.h"
#include "dsp/calib/pmd/frequency_pair.h"
#include "dsp/calib/stereo/column_tables.h"
#include "dsp/calib/stereo/rectification.h"

namespace stof::dsp {
namespace {

bool finite_positive(double value) noexcept { return std::isfinite(value) && value > 0; }

// What no rig goes beyond. docs: docs/CALIBRATION.md.
constexpr double kMostPixels = 1e5;  // of a focal length; of a centre from the picture's corner
constexpr double kMostDistortion = 1000;
constexpr double kLeastBaselineM = 1e-3;
constexpr double kMostBaselineM = 100;
constexpr double kLeastElectrons = 1e-3;  // per LSB
constexpr double kMostElectrons = 1e6;
constexpr double kMostNoiseLsb = 65535;
constexpr double kMostLightLsb = 1e7;  // suppressed, or of a white surface at 1 m

bool within(double value, double limit) noexcept { return std::abs(value) <= limit; }

bool between(double value, double low, double high) noexcept {
  return value >= low && value <= high;
}

bool usable(const Pinhole& lens) noexcept {
  return lens.width > 0 && lens.height > 0 && between(lens.fx, 1, kMostPixels) &&
         between(lens.fy, 1, kMostPixels) && within(lens.cx, kMostPixels) &&
         within(lens.cy, kMostPixels) &&
         std::ranges::all_of(std::array{lens.k1, lens.k2, lens.k3, lens.p1, lens.p2},
                             [](double k) { return within(k, kMostDistortion); });
}

// A mirror is not a rotation.
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
  return r[0] * (r[4] * r[8] - r[5] * r[7]) - r[1] * (r[3] * r[8] - r[5] * r[6]) +
             r[2] * (r[3] * r[7] - r[4] * r[6]) >
         0;
}

bool near_home(const std::array<double, 3>& translation_m) noexcept {
  return std::ranges::all_of(translation_m, [](double t) { return std::abs(t) < 100; });
}

const char* raw_problem(const RawPair& raw) noexcept {
  if (!usable(raw.left) || !usable(raw.right)) {
    return "a raw camera has no size, a focal length outside 1 to 100000 px, or a centre or "
           "distortion that is not usable";
  }
  if (!orthonormal(raw.left_to_right.rotation)) {
    return "the rotation from left to right is not orthonormal";
  }
  if (!near_home(raw.left_to_right.translation_m)) {
    return "the translation from left to right is not usable";
  }
  return problem_of(raw);
}

const char* baseline_problem(const StereoRig& rig) noexcept {
  return between(rig.baseline_m, kLeastBaselineM, kMostBaselineM)
             ? ""
             : "the baseline of the stereo pair is outside 1 mm to 100 m";
}

const char* converging_problem(const StereoRig& rig) noexcept {
  const Converging& c = *rig.converging;
  if (!(std::abs(c.alpha_rad) < kSteepestRad) || !(std::abs(c.beta_rad) < kSteepestRad) ||
      !finite_positive(c.f1_m) || !finite_positive(c.f2_m) || !finite_positive(c.pixel_m) ||
      !std::isfinite(c.cx_left) || !std::isfinite(c.cx_right)) {
    return "the converging axes have an angle, focal length, pixel or centre that is not usable";
  }
  if (const char* const why = baseline_problem(rig); *why != '\0') {
    return why;
  }
  for (const double x : {0.0, rig.left.width - 1.0}) {
    if (std::isnan(left_tangent(rig, x)) || std::isnan(right_tangent(rig, x))) {
      return "a picture of the converging axes reaches further than 75 degrees from the "
             "perpendicular of the baseline";
    }
  }
  return "";
}

const char* both_problem(const StereoRig& rig) noexcept {
  if (rig.raw && rig.converging) {
    return "the pair is to be rectified, and converges without: leave one of both out";
  }
  if (rig.raw) {
    return raw_problem(*rig.raw);
  }
  return rig.converging ? converging_problem(rig) : "";
}

const char* pair_problem(const StereoRig& rig) noexcept {
  if (const char* const why = baseline_problem(rig); *why != '\0') {
    return why;
  }
  const bool parallel = !rig.raw && !rig.converging;
  if (!std::isfinite(rig.doff_px) || (parallel && !within(rig.doff_px, rig.left.width))) {
    return "the disparity offset is larger than the left picture is wide";
  }
  return both_problem(rig);
}

const char* frequency_problem(const PmdFrequency& frequency) noexcept {
  if (frequency.modulation.value < 1'000'000 || frequency.modulation.value > 200'000'000) {
    return "a PMD modulation frequency is outside 1 to 200 MHz";
  }
  if (!(frequency.min_modulation_ratio >= 0) || !(frequency.min_modulation_ratio <= 1)) {
    return "a PMD modulation ratio is outside 0 to 1";
  }
  if (!within(frequency.offset_m, 1000) || !within(frequency.offset_m_per_k, 1)) {
    return "a PMD offset is above 1000 m, or above 1 m for each kelvin";
  }
  if (!within(frequency.stray_i_lsb, 32767) || !within(frequency.stray_q_lsb, 32767)) {
    return "the stray light of the PMD camera is above 32767 LSB";
  }
  return "";
}

const char* samples_problem(const PmdSensor& pmd) noexcept {
  if (!(pmd.dark_lsb >= 0) || !(pmd.dark_lsb < 32768)) {
    return "the dark level of a PMD sample is outside 0 to 32768 LSB";
  }
  if (pmd.saturation_lsb < 1 || pmd.under_lsb >= pmd.saturation_lsb) {
    return "a PMD sample saturates below 1 LSB, or where it is under range";
  }
  if (!(pmd.dark_lsb < pmd.saturation_lsb)) {
    return "the dark level of a PMD sample is not below its saturation";
  }
  if (pmd.min_amplitude_lsb < 0) {
    return "the least amplitude of the PMD camera is negative";
  }
  if (!between(pmd.electrons_per_lsb, kLeastElectrons, kMostElectrons)) {
    return "the PMD noise model has electrons per LSB outside 0.001 to 1000000";
  }
  if (!between(pmd.noise_lsb, 0, kMostNoiseLsb) || !between(pmd.suppressed_lsb, 0, kMostLightLsb)) {
    return "the PMD noise model has noise outside 0 to 65535 LSB, or suppressed light outside 0 to "
           "10000000 LSB";
  }
  if (!finite_positive(pmd.asymmetry_sigmas)) {
    return "the greatest asymmetry of PMD samples is not positive";
  }
  if (!between(pmd.white_lsb, 0, kMostLightLsb)) {
    return "the PMD amplitude of a white surface is outside 0 to 10000000 LSB";
  }
  if (!between(pmd.integration_us, 0, 1e7)) {
    return "the PMD integration time is outside 0 to 10 s";
  }
  return "";
}

// Which every metre of the range needs a value of.
bool tells_noise(const SigmaPolynomial& sigma) noexcept {
  for (int metres = 1; metres <= 16; ++metres) {
    const double z = 100.0 * metres;
    if (!finite_positive(sigma.a + z * (sigma.b + z * sigma.c))) {
      return false;
    }
  }
  return true;
}

const char* distance_problem(const PmdSensor& pmd) noexcept {
  if (!(pmd.scale >= 0.5) || !(pmd.scale <= 2) || !within(pmd.shift_m, 100)) {
    return "the straight line of PMD distances has a scale outside 0.5 to 2, or a shift above 100 "
           "m";
  }
  if (!within(pmd.reference_c, 200)) {
    return "the reference temperature of the PMD camera is outside -200 to 200 degrees";
  }
  if (pmd.sigma_polynomial && !tells_noise(*pmd.sigma_polynomial)) {
    return "the PMD polynomial of sigma is not positive everywhere from 1 to 16 m";
  }
  if (pmd.emitter_count < 0 || pmd.emitter_count > kMaxEmitters) {
    return "the PMD camera has less than 0 or more than 4 lights";
  }
  for (std::size_t i = 0; i < index(pmd.emitter_count); ++i) {
    const Emitter& e = pmd.emitters[i];
    if (!within(std::hypot(e[0], e[1], e[2]), 2)) {
      return "a light of the PMD camera is more than 2 m from its lens";
    }
  }
  return "";
}

const char* second_problem(const PmdSensor& pmd) noexcept {
  if (const char* const why = frequency_problem(*pmd.second); *why != '\0') {
    return why;
  }
  if (pmd.second->modulation.value >= pmd.frequency.modulation.value) {
    return "the second PMD modulation frequency is not below the first";
  }
  if (!usable_pair(pmd.frequency.modulation, pmd.second->modulation)) {
    return "the two PMD modulation frequencies are no ratio of whole numbers up to 64";
  }
  return "";
}

const char* pmd_problem(const PmdSensor& pmd) noexcept {
  if (!usable(pmd.lens)) {
    return "the PMD lens has no size, a focal length outside 1 to 100000 px, or a centre or "
           "distortion that is not usable";
  }
  for (const char* const why :
       {frequency_problem(pmd.frequency), pmd.second ? second_problem(pmd) : "",
        samples_problem(pmd), distance_problem(pmd)}) {
    if (*why != '\0') {
      return why;
    }
  }
  const std::size_t pixels = pixel_count(pmd.lens.width, pmd.lens.height);
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
    table[index(i)] = static_cast<std::int16_t>(std::lround(wiggle / kTurn * 65536));
  }
  return table;
}

WigglingTable wiggling_of_harmonics(double kappa3, double kappa5) noexcept {
  constexpr double kTurn = 2 * std::numbers::pi;
  constexpr int kRounds = 60;  // each leaves at most 4 (|kappa3| + |kappa5|) of what was wrong
  WigglingTable table{};
  for (int i = 0; i < kWigglingSteps; ++i) {
    const double measured = kTurn * i / kWigglingSteps;
    double added = 0;
    for (int round = 0; round < kRounds; ++round) {
      const double four = 4 * (measured - added);
      added =
          std::atan2((kappa5 - kappa3) * std::sin(four), 1 + (kappa3 + kappa5) * std::cos(four));
    }
    table[index(i)] = static_cast<std::int16_t>(std::lround(added / kTurn * 65536));
  }
  return table;
}

const char* complete(StereoRig& rig) noexcept {
  if (const char* const why = both_problem(rig); *why != '\0') {
    return why;
  }
  if (rig.raw) {
    const Rectification rectified = rectify(*rig.raw);
    rig.left = rectified.left;
    rig.baseline_m = rectified.baseline_m;
    rig.doff_px = rectified.right.cx - rectified.left.cx;
  } else if (rig.converging) {
    // Value and slope of T_l at the left principal column, value of T_r at the right one.
    const Converging& c = *rig.converging;
    const double toward = std::cos(c.beta_rad);
    rig.left.fx = c.f2_m / c.pixel_m * toward * toward;
    rig.left.cx = c.cx_left + rig.left.fx * std::tan(c.beta_rad);
    rig.doff_px =
        c.cx_right - c.cx_left + rig.left.fx * (std::tan(c.alpha_rad) - std::tan(c.beta_rad));
  }
  return "";
}

const char* problem(const Calibration& calibration) noexcept {
  if (!usable(calibration.stereo.left)) {
    return "the left camera has no size, a focal length outside 1 to 100000 px, or a centre or "
           "distortion that is not usable";
  }
  if (const char* const why = pair_problem(calibration.stereo); *why != '\0') {
    return why;
  }
  const Pinhole& pmd = calibration.pmd.lens;
  if (pmd.width == 0 && pmd.height == 0) {
    return "";  // stereo only
  }
  if (!orthonormal(calibration.pmd_to_stereo.rotation)) {
    return "the rotation from PMD to stereo is not orthonormal";
  }
  if (!near_home(calibration.pmd_to_stereo.translation_m)) {
    return "the translation from PMD to stereo is not usable";
  }
  return pmd_problem(calibration.pmd);
}

}  // namespace stof::dsp
