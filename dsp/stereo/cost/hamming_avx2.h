#pragma once

#include <cstddef>
#include <cstdint>

#include "dsp/base/lanes_avx2.h"
#include "dsp/stereo/cost/hamming_body.h"

namespace stof::dsp::avx2 {

// hamming_neon.h for 32 candidates a step.
struct Hamming : Lanes<std::uint8_t> {
  template <std::size_t kPlanes, std::size_t kVectors>
  [[gnu::always_inline]] static void distances(hamming_body::Planes left,
                                               hamming_body::Planes right,
                                               V (&out)[kVectors]) noexcept {
    static_assert(kPlaneBits == 4);
    for (V& distance : out) {
      distance = V{};
    }
    for (std::size_t p = 0; p < kPlanes; ++p) {
      const std::uint8_t* const candidates = right.first + p * right.stride;
      const auto* const of_own = reinterpret_cast<const __m128i*>(  // NOLINT: any type
          hamming_body::kDistances[left.first[p * left.stride]].data());
      const __m256i table = _mm256_broadcastsi128_si256(_mm_loadu_si128(of_own));
      for (std::size_t v = 0; v < kVectors; ++v) {
        const V four_bits = load(candidates + kLanes * v);
        out[v] += as<V>(_mm256_shuffle_epi8(table, bits(four_bits)));
      }
    }
  }
};

}  // namespace stof::dsp::avx2
