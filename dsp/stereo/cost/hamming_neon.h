#pragma once

#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>

#include "dsp/base/simd.h"
#include "dsp/base/target.h"

// The Hamming distances of one left column from neighbouring candidates, for the *_neon.cpp of this
// folder.
namespace stof::dsp::neon {

// kDistances[a][b]: bits in which four bits a differ from four bits b.
inline constexpr auto kDistances = [] {
  std::array<std::array<std::uint8_t, 16>, 16> distances{};
  for (unsigned a = 0; a < 16; ++a) {
    for (unsigned b = 0; b < 16; ++b) {
      distances[a][b] = static_cast<std::uint8_t>(std::popcount(a ^ b));
    }
  }
  return distances;
}();

// Where the planes of a row begin, and how far apart they are.
struct Planes {
  const std::uint8_t* first;
  std::size_t stride;
};

// distances[v] = those of candidates 16 v .. 16 v + 15 from the left column at left.first; the
// first candidate is at right.first. Per 16 candidates and plane this is a load, one or two
// operations and a sum: looking four bits up costs x86 two thirds of counting eight, ARM a third
// more.
template <std::size_t kPlanes, std::size_t kVectors>
inline void hamming_distances(Planes left, Planes right,
                              uint8x16_t (&distances)[kVectors]) noexcept {
  for (uint8x16_t& distance : distances) {
    distance = vdupq_n_u8(0);
  }
  for (std::size_t p = 0; p < kPlanes; ++p) {
    const std::uint8_t own = left.first[p * left.stride];
    const std::uint8_t* const candidates = right.first + p * right.stride;
    if constexpr (kPlaneBits == 8) {
      const uint8x16_t bits = vdupq_n_u8(own);
      for (std::size_t v = 0; v < kVectors; ++v) {
        const uint8x16_t differing = veorq_u8(bits, vld1q_u8(candidates + 16 * v));
        distances[v] = vaddq_u8(distances[v], vcntq_u8(differing));
      }
    } else {
      const uint8x16_t table = vld1q_u8(kDistances[own].data());
      for (std::size_t v = 0; v < kVectors; ++v) {
        const uint8x16_t distance = simd::look_up(table, vld1q_u8(candidates + 16 * v));
        distances[v] = vaddq_u8(distances[v], distance);
      }
    }
  }
}

}  // namespace stof::dsp::neon
