#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

#include "dsp/base/fixed.h"
#include "dsp/base/kernel.h"

namespace stof::dsp {

// Two modulation frequencies f1 = m f0 and f2 = n f0, m and n without a common divisor, m > n: what
// the kernel needs of them. dsp/calib/pmd/frequency_pair.h makes it.
struct FrequencyPair {
  std::uint32_t m = 2;  // at most kMostTurns
  std::uint32_t n = 1;
  std::uint32_t inverse = 1;        // of n, modulo m
  std::uint32_t turn_q11 = 1;       // 0.1 mm a turn of f1, 11 fraction bits
  std::uint32_t tolerance = 16384;  // tau in 1/65536 turn, at most 32768
  // Limit for the difference of both distances, quarter mm squared; 2^32 - 1 is none.
  std::uint32_t max_variance = ~0U;
};
inline constexpr std::uint32_t kMostTurns = 64;

// One frequency of a row. sigma: standard deviation of its distance, in both frequencies or in none
// (empty).
struct FrequencyReadings {
  std::span<const Phase> phase;  // corrected: proportional to distance
  std::span<const std::uint16_t> amp2;
  std::span<const QuarterMm> sigma;
};

// The distance that both phases tell together, unambiguous up to c / (2 f0), for one row:
//   E = m phi2 - n phi1, q = (E + 32768) >> 16, e = E - 65536 q    e is 0 but for noise
//   k1 = (q inverse) mod m                                         turns that phi1 has lost
//   D = 16 (65536 k1 + phi1) + 16 w e / n, modulo the range        1/16 phase unit
//   w = (n A2)^2 / ((m A1)^2 + (n A2)^2)
//   distance = D turn_q11 / 2^31 to nearest, 0.1 mm, at least 1
// That is the mean of D1 and D2 weighted by (f A)^2, since they differ by e / n; at the ends of the
// range it wraps as a whole. 16 w e / n by IEEE single operations, with one division for w, in the
// order of the reference, then to nearest, ties to even.
// flags (of the first frequency when called) gets other_flags, and kPmdWrapped
//   where |e| > tolerance: the phases contradict each other, k1 is not known;
//   where sigma1^2 + sigma2^2 > max_variance: they would agree by chance.
// Where flags has a bit of kPmdMissing then, distance is 0. Equal lengths, any length, any
// alignment; no overlap.
using CombineFrequencies = void(const FrequencyReadings& first, const FrequencyReadings& second,
                                const FrequencyPair& pair,
                                std::span<const std::uint8_t> other_flags,
                                std::span<std::uint8_t> flags,
                                std::span<std::uint32_t> distance) noexcept;
STOF_KERNEL(CombineFrequencies, combine_frequencies, kNeon)

// Readings of equal lengths, `count`, and a pair as above.
void check_combine_frequencies(const FrequencyReadings& first, const FrequencyReadings& second,
                               const FrequencyPair& pair, std::size_t count) noexcept;

}  // namespace stof::dsp
