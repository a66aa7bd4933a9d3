#pragma once

#include <array>
#include <cmath>
#include <numbers>

#include "dataset/dataset.h"
#include "dsp/calib/pmd_sensor.h"
#include "hal/emu/imagery/imagery.h"
#include "hal/emu/imagery/pmd_samples.h"
#include "hal/emu/scenes/rig.h"

// What tests of rendered scenes have in common.
namespace stof::test {

// A quarter of the pixels a side, for speed.
inline hal::emu::Rig small(hal::emu::Rig rig) {
  hal::emu::resize_stereo(rig, rig.stereo.left.width / 4, rig.stereo.left.height / 4);
  hal::emu::resize_pmd(rig, rig.pmd_lens.width / 4, rig.pmd_lens.height / 4);
  rig.pmd.rays_per_side = 2;
  return rig;
}

struct Exposed {
  dataset::Image<std::uint8_t> left;
  dataset::Image<std::uint8_t> right;
  std::array<dataset::Image<std::uint16_t>, 4> samples;
};

inline Exposed expose(hal::emu::Imagery& imagery, std::uint32_t number) {
  const hal::emu::Size stereo = imagery.stereo_size();
  const hal::emu::Size pmd = imagery.pmd_size();
  Exposed out{
      .left = {stereo.width, stereo.height}, .right = {stereo.width, stereo.height}, .samples = {}};
  imagery.left(number, out.left.view());
  imagery.right(number, out.right.view());
  for (int k = 0; k < 4; ++k) {
    dataset::Image<std::uint16_t>& sample = out.samples[static_cast<std::size_t>(k)];
    sample = {pmd.width, pmd.height};
    imagery.pmd(number, k, sample.view());
  }
  return out;
}

// FNV-1a, by words.
inline std::uint64_t hash(const Exposed& exposed) {
  std::uint64_t state = 0xCBF29CE484222325ULL;
  const auto add = [&](std::uint64_t value) { state = (state ^ value) * 0x100000001B3ULL; };
  for (const std::uint8_t pixel : exposed.left.pixels) {
    add(pixel);
  }
  for (const std::uint8_t pixel : exposed.right.pixels) {
    add(pixel);
  }
  for (const auto& sample : exposed.samples) {
    for (const std::uint16_t pixel : sample.pixels) {
      add(pixel);
    }
  }
  return state;
}

// One pixel's four samples as the calibration understands them, in doubles.
struct Decoded {
  double turns = 0;      // fixed pattern, wiggling and offset taken out; 0 .. 1
  double amplitude = 0;  // LSB
  double ratio = 0;      // of modulation
};

inline Decoded decode(const dsp::PmdSensor& sensor, const std::array<double, 4>& samples,
                      std::size_t pixel) {
  const dsp::PmdFrequency& frequency = sensor.frequency;
  const double i = samples[0] - samples[2] - frequency.stray_i_lsb;
  const double q = samples[3] - samples[1] - frequency.stray_q_lsb;
  const double turn_m = dsp::kLightMetresPerSecond / (2.0 * frequency.modulation.value);
  double turns = std::atan2(q, i) / (2 * std::numbers::pi);
  if (!sensor.fixed_pattern.empty()) {
    turns -= sensor.fixed_pattern[pixel] / 65536.0;
  }
  turns -= std::floor(turns);
  const double place = turns * dsp::kWigglingSteps;
  const std::size_t step = static_cast<std::size_t>(place) % dsp::kWigglingSteps;
  const double low = frequency.wiggling[step];
  const double high = frequency.wiggling[(step + 1) % dsp::kWigglingSteps];
  turns -= (low + (high - low) * (place - std::floor(place))) / 65536 + frequency.offset_m / turn_m;
  const double mean = (samples[0] + samples[1] + samples[2] + samples[3]) / 4 - sensor.dark_lsb;
  const double amplitude = std::hypot(i, q) / 2;
  return {.turns = turns - std::floor(turns), .amplitude = amplitude, .ratio = amplitude / mean};
}

// How much farther than `truth_m` the reading is, in the period that is nearest to it. Metres.
inline double range_error(const dsp::PmdSensor& sensor, const Decoded& decoded, double truth_m) {
  const double turn_m = dsp::kLightMetresPerSecond / (2.0 * sensor.frequency.modulation.value);
  return std::remainder(decoded.turns * turn_m - truth_m, turn_m);
}

inline std::array<double, 4> clean_samples(const hal::emu::CleanSamples& clean, int x, int y) {
  std::array<double, 4> out{};
  for (int k = 0; k < 4; ++k) {
    out[static_cast<std::size_t>(k)] = clean.mean.view().at(x, k * clean.mean.height / 4 + y) /
                                       static_cast<double>(1 << hal::emu::kPmdBits);
  }
  return out;
}

}  // namespace stof::test
