#include "dsp/calib/pmd/frequency_pair.h"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "dsp/base/check.h"

namespace stof::dsp {
namespace {

constexpr double kSigmas = 5;
constexpr int kTurnBits = 11;  // of turn_q11

double turn_m(Hertz modulation) noexcept {
  return kLightMetresPerSecond / (2.0 * modulation.value);
}

std::uint32_t inverse_of(std::uint32_t n, std::uint32_t m) noexcept {
  std::uint32_t inverse = 1;
  while (inverse * n % m != 1 % m) {
    ++inverse;
  }
  return inverse;
}

}  // namespace

bool usable_pair(Hertz first, Hertz second) noexcept {
  return second.value > 0 && first.value > second.value &&
         first.value / std::gcd(first.value, second.value) <= kMostTurns;
}

FrequencyPair make_frequency_pair(Hertz first, Hertz second) noexcept {
  STOF_CHECK(usable_pair(first, second));
  const std::uint32_t common = std::gcd(first.value, second.value);
  FrequencyPair pair;
  pair.m = first.value / common;
  pair.n = second.value / common;
  pair.inverse = inverse_of(pair.n, pair.m);
  const double turn = turn_m(first);
  pair.turn_q11 = static_cast<std::uint32_t>(std::lround(turn * 10000 * (1 << kTurnBits)));
  // e = n (d2 - d1) / turn, in turns.
  const double largest = (1 - pair.tolerance / 65536.0) / kSigmas * turn * kQuarterMmPerMetre;
  const double variance = largest / pair.n * (largest / pair.n);
  pair.max_variance = static_cast<std::uint32_t>(std::min(std::round(variance), 4294967295.0));
  return pair;
}

std::uint32_t common_range(const FrequencyPair& pair) noexcept {
  const std::uint64_t product = std::uint64_t{pair.turn_q11} * pair.m;
  return static_cast<std::uint32_t>(round_shift(product, kTurnBits));
}

}  // namespace stof::dsp
