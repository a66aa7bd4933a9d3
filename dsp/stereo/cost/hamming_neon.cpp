#include "dsp/stereo/cost/hamming.h"

#include <cstddef>

#include "dsp/base/check.h"
#include "dsp/base/simd.h"
#include "dsp/stereo/cost/hamming_neon.h"

namespace stof::dsp::neon {
namespace {

template <std::size_t kPlanes, std::size_t kVectors>
void strip(Planes left, Planes right, std::uint8_t* costs) noexcept {
  uint8x16_t distances[kVectors];
  hamming_distances<kPlanes>(left, right, distances);
  for (std::size_t v = 0; v < kVectors; ++v) {
    vst1q_u8(costs + 16 * v, distances[v]);
  }
}

template <std::size_t kPlanes>
void compare(std::span<const std::uint8_t> left, std::span<const std::uint8_t> right,
             std::size_t lanes, std::span<std::uint8_t> costs) noexcept {
  const std::size_t n = costs.size() / lanes;
  const std::size_t stride = n + lanes - 1;
  STOF_CHECK(costs.size() == n * lanes && left.size() == kPlanes * n &&
             right.size() == kPlanes * stride);
  for (std::size_t k = 0; k < n; ++k) {
    const Planes own{left.data() + k, n};
    const std::uint8_t* const candidates = right.data() + (n - 1 - k);
    std::uint8_t* const pixel = costs.data() + k * lanes;
    std::size_t i = 0;
    for (; i + 64 <= lanes; i += 64) {
      strip<kPlanes, 4>(own, {candidates + i, stride}, pixel + i);
    }
    for (; i < lanes; i += 16) {
      strip<kPlanes, 1>(own, {candidates + i, stride}, pixel + i);
    }
  }
}

}  // namespace

void hamming_costs(std::span<const std::uint8_t> left, std::span<const std::uint8_t> right,
                   int bits, int lanes, std::span<std::uint8_t> costs) noexcept {
  STOF_CHECK(bits == kCensus5x5Bits || bits == kCensus9x7Bits);
  STOF_CHECK(lanes >= kCostLanes && lanes % kCostLanes == 0 && !costs.empty());
  if (bits == kCensus5x5Bits) {
    compare<planes_of(kCensus5x5Bits)>(left, right, static_cast<std::size_t>(lanes), costs);
  } else {
    compare<planes_of(kCensus9x7Bits)>(left, right, static_cast<std::size_t>(lanes), costs);
  }
}

}  // namespace stof::dsp::neon
