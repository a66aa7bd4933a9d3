#include "dsp/pmd/range/combine_frequencies.h"

#include <algorithm>
#include <cstddef>
#include <cstdlib>

#include "dsp/base/check.h"
#include "dsp/pmd/pmd_maps.h"

namespace stof::dsp {

void check_combine_frequencies(const FrequencyReadings& first, const FrequencyReadings& second,
                               const FrequencyPair& pair, std::size_t count) noexcept {
  STOF_CHECK(first.phase.size() == count && second.phase.size() == count);
  STOF_CHECK(first.amp2.size() == count && second.amp2.size() == count);
  STOF_CHECK(first.sigma.size() == second.sigma.size());
  STOF_CHECK(first.sigma.empty() || first.sigma.size() == count);
  STOF_CHECK(pair.n >= 1 && pair.n < pair.m && pair.m <= kMostTurns && pair.inverse < pair.m);
}

namespace ref {
namespace {

constexpr int kTurn = 65536;
constexpr int kParts = 16;  // of a phase unit
constexpr int kDistanceBits = 31;

// Nearest integer, ties to even, for |v| < 2^22.
int nearest_even(float v) noexcept { return static_cast<int>(v + 12582912.0F) - 12582912; }

// E and what it says.
struct Beat {
  int turns;  // q modulo m
  int rest;   // e
};

Beat beat_of(Phase phi1, Phase phi2, int m, int n) noexcept {
  const int beat = m * phi2 - n * phi1;
  const int q = round_shift(beat, 16);
  return {(q + m) % m, beat - q * kTurn};
}

// 16 w e / n.
int correction(std::uint16_t amp2, std::uint16_t other, int rest,
               const FrequencyPair& pair) noexcept {
  const float near = static_cast<float>(pair.m * amp2);
  const float far = static_cast<float>(pair.n * other);
  const float near_power = near * near;
  const float far_power = far * far;
  const float weight = far_power / std::max(near_power + far_power, 1.0F);
  const float share = static_cast<float>(kParts) / static_cast<float>(pair.n);
  return nearest_even(weight * share * static_cast<float>(rest));
}

bool noisy(const FrequencyReadings& first, const FrequencyReadings& second, std::size_t x,
           std::uint32_t max_variance) noexcept {
  if (first.sigma.empty()) {
    return false;
  }
  const std::uint64_t a = first.sigma[x];
  const std::uint64_t b = second.sigma[x];
  return std::min<std::uint64_t>(a * a + b * b, 0xFFFFFFFF) > max_variance;
}

}  // namespace

void combine_frequencies(const FrequencyReadings& first, const FrequencyReadings& second,
                         const FrequencyPair& pair, std::span<const std::uint8_t> other_flags,
                         std::span<std::uint8_t> flags,
                         std::span<std::uint32_t> distance) noexcept {
  const std::size_t count = distance.size();
  check_combine_frequencies(first, second, pair, count);
  STOF_CHECK(other_flags.size() == count && flags.size() == count);
  const int m = static_cast<int>(pair.m);
  const int n = static_cast<int>(pair.n);
  const int range = m * kTurn * kParts;
  for (std::size_t x = 0; x < count; ++x) {
    const Beat beat = beat_of(first.phase[x], second.phase[x], m, n);
    const int turns = beat.turns * static_cast<int>(pair.inverse) % m;
    int way = (turns * kTurn + first.phase[x]) * kParts +
              correction(first.amp2[x], second.amp2[x], beat.rest, pair);
    way = (way + range) % range;
    const bool wrapped = std::abs(beat.rest) > static_cast<int>(pair.tolerance) ||
                         noisy(first, second, x, pair.max_variance);
    const int flag = flags[x] | other_flags[x] | (wrapped ? kPmdWrapped : 0);
    flags[x] = static_cast<std::uint8_t>(flag);
    const std::uint64_t product = std::uint64_t{static_cast<std::uint32_t>(way)} * pair.turn_q11;
    const std::uint64_t tenths = std::max<std::uint64_t>(round_shift(product, kDistanceBits), 1);
    distance[x] = (flag & kPmdMissing) != 0 ? 0 : static_cast<std::uint32_t>(tenths);
  }
}

}  // namespace ref
}  // namespace stof::dsp
