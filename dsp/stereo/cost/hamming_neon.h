#pragma once

#include <cstddef>
#include <cstdint>

#include "dsp/base/lanes_neon.h"
#include "dsp/base/target.h"
#include "dsp/stereo/cost/hamming_body.h"

namespace stof::dsp::neon {

// The Hamming distances of one left column from neighbouring candidates.
struct Hamming : Lanes<std::uint8_t> {
  // out[v] = those of candidates 16 v .. 16 v + 15 from the left column at left.first; the first
  // candidate is at right.first. Per 16 candidates and plane this is a load, one or two operations
  // and a sum: looking four bits up costs x86 two thirds of counting eight, ARM a third more.
  template <std::size_t kPlanes, std::size_t kVectors>
  static void distances(hamming_body::Planes left, hamming_body::Planes right,
                        V (&out)[kVectors]) noexcept {
    for (V& distance : out) {
      distance = all(0);
    }
    for (std::size_t p = 0; p < kPlanes; ++p) {
      const std::uint8_t own = left.first[p * left.stride];
      const std::uint8_t* const candidates = right.first + p * right.stride;
      if constexpr (kPlaneBits == 8) {
        const V bits = all(own);
        for (std::size_t v = 0; v < kVectors; ++v) {
          out[v] = out[v] + vcntq_u8(bits ^ load(candidates + kLanes * v));
        }
      } else {
        const V table = load(hamming_body::kDistances[own].data());
        for (std::size_t v = 0; v < kVectors; ++v) {
          out[v] = out[v] + simd::look_up(table, load(candidates + kLanes * v));
        }
      }
    }
  }
};

}  // namespace stof::dsp::neon
