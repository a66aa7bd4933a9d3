#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

#include "dsp/base/avx2.h"

// The Hamming distances of one left column from neighbouring candidates, for the *_avx2.cpp of this
// folder: hamming_neon.h for 32 candidates a step.
namespace stof::dsp::avx2 {

// kDistances[a][b]: bits in which four bits a differ from four bits b.
alignas(16) static constexpr auto kDistances = [] {
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

// distances[v] = those of candidates 32 v .. 32 v + 31 from the left column at left.first; the
// first candidate is at right.first.
template <std::size_t kPlanes, std::size_t kVectors>
[[gnu::always_inline]] static inline void hamming_distances(Planes left, Planes right,
                                                            u8x32 (&distances)[kVectors]) noexcept {
  static_assert(kPlaneBits == 4);
  for (u8x32& distance : distances) {
    distance = u8x32{};
  }
  for (std::size_t p = 0; p < kPlanes; ++p) {
    const std::uint8_t* const candidates = right.first + p * right.stride;
    const auto* const of_own = reinterpret_cast<const __m128i*>(  // NOLINT: any type
        kDistances[left.first[p * left.stride]].data());
    const __m256i table = _mm256_broadcastsi128_si256(_mm_loadu_si128(of_own));
    for (std::size_t v = 0; v < kVectors; ++v) {
      const u8x32 four_bits = load<u8x32>(candidates + 32 * v);
      distances[v] += as<u8x32>(_mm256_shuffle_epi8(table, bits(four_bits)));
    }
  }
}

}  // namespace stof::dsp::avx2
