#include "dsp/stereo/cost/hamming.h"

#include <cstddef>

#include "dsp/base/avx2.h"
#include "dsp/base/check.h"
#include "dsp/stereo/cost/hamming_avx2.h"

namespace stof::dsp::avx2 {
namespace {

template <std::size_t kPlanes, std::size_t kVectors>
void strip(Planes left, Planes right, std::uint8_t* costs) noexcept {
  u8x32 distances[kVectors];
  hamming_distances<kPlanes>(left, right, distances);
  for (std::size_t v = 0; v < kVectors; ++v) {
    store(costs + 32 * v, distances[v]);
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
      strip<kPlanes, 2>(own, {candidates + i, stride}, pixel + i);
    }
    if (i < lanes) {
      strip<kPlanes, 1>(own, {candidates + i, stride}, pixel + i);
    }
  }
}

}  // namespace

void hamming_costs(std::span<const std::uint8_t> left, std::span<const std::uint8_t> right,
                   int bits, int lanes, std::span<std::uint8_t> costs) noexcept {
  if (lanes % 32 != 0) {
    neon::hamming_costs(left, right, bits, lanes, costs);
    return;
  }
  STOF_CHECK(bits == kCensus5x5Bits || bits == kCensus9x7Bits);
  STOF_CHECK(lanes > 0 && !costs.empty());
  if (bits == kCensus5x5Bits) {
    compare<planes_of(kCensus5x5Bits)>(left, right, static_cast<std::size_t>(lanes), costs);
  } else {
    compare<planes_of(kCensus9x7Bits)>(left, right, static_cast<std::size_t>(lanes), costs);
  }
}

}  // namespace stof::dsp::avx2
