#include "host/evaluate/pmd/phase.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <random>
#include <vector>

#include "dsp/pmd/phase/phase.h"

namespace stof::host {
namespace {

constexpr std::size_t kRow = 4093;  // no multiple of a vector: tails are compared too

struct Outputs {
  std::vector<dsp::Phase> phase;
  std::vector<std::uint16_t> amp2;
  std::vector<std::uint16_t> offset;
  std::vector<std::uint8_t> flags;
  friend bool operator==(const Outputs&, const Outputs&) = default;
};

Outputs run(dsp::PhaseKernel& kernel, const std::array<std::vector<std::uint16_t>, 4>& samples,
            std::size_t n) {
  Outputs out{std::vector<dsp::Phase>(n), std::vector<std::uint16_t>(n),
              std::vector<std::uint16_t>(n), std::vector<std::uint8_t>(n)};
  const auto row = [&samples, n](std::size_t k) { return std::span(samples[k]).first(n); };
  const dsp::PhaseLimits limits{.dark = 100};
  kernel({row(0), row(1), row(2), row(3)}, limits, {out.phase, out.amp2, out.offset, out.flags});
  return out;
}

}  // namespace

PhaseScore score_phase(long pixels, int bits, std::uint64_t seed) {
  constexpr double kTurn = 65536;
  std::mt19937_64 random(seed);
  std::array<std::vector<std::uint16_t>, 4> samples;
  samples.fill(std::vector<std::uint16_t>(kRow));
  const std::uint64_t mask = (std::uint64_t{1} << static_cast<unsigned>(bits)) - 1;
  constexpr unsigned kEach = 16;
  PhaseScore score{.pixels = pixels};
  double sum = 0;
  for (long done = 0; done < pixels;) {
    const std::size_t n = std::min<std::size_t>(kRow, static_cast<std::size_t>(pixels - done));
    for (std::size_t i = 0; i < n; ++i) {
      std::uint64_t bits_left = random();
      for (std::vector<std::uint16_t>& plane : samples) {
        plane[i] = static_cast<std::uint16_t>(bits_left & mask);
        bits_left >>= kEach;
      }
    }
    const Outputs reference = run(dsp::ref::phase, samples, n);
    score.kernels_equal &= run(dsp::neon::phase, samples, n) == reference;
    for (std::size_t i = 0; i < n; ++i) {
      const int in = samples[0][i] - samples[2][i];
      const int quad = samples[3][i] - samples[1][i];
      if (in == 0 && quad == 0) {
        continue;  // no phase
      }
      const double exact = std::atan2(quad, in) / (2 * std::numbers::pi) * kTurn;
      const double error = std::abs(std::remainder(reference.phase[i] - exact, kTurn));
      score.largest_lsb = std::max(score.largest_lsb, error);
      sum += error;
    }
    done += static_cast<long>(n);
  }
  score.mean_lsb = pixels > 0 ? sum / static_cast<double>(pixels) : 0;
  return score;
}

}  // namespace stof::host
