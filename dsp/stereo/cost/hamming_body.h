#pragma once

#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <span>

#include "dsp/base/check.h"
#include "dsp/stereo/cost/census.h"

// The walk over a row of pixels that the vector variants of hamming.h share. Isa is the Hamming of
// hamming_neon.h or hamming_avx2.h: a vector V of kLanes candidates, distances() and store().
namespace stof::dsp::hamming_body {

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

template <typename Isa, std::size_t kPlanes, std::size_t kVectors>
void strip(Planes left, Planes right, std::uint8_t* costs) noexcept {
  typename Isa::V distances[kVectors];
  Isa::template distances<kPlanes>(left, right, distances);
  for (std::size_t v = 0; v < kVectors; ++v) {
    Isa::store(costs + Isa::kLanes * v, distances[v]);
  }
}

template <typename Isa, std::size_t kPlanes>
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
      strip<Isa, kPlanes, 64 / Isa::kLanes>(own, {candidates + i, stride}, pixel + i);
    }
    for (; i < lanes; i += Isa::kLanes) {
      strip<Isa, kPlanes, 1>(own, {candidates + i, stride}, pixel + i);
    }
  }
}

// lanes a multiple of Isa::kLanes.
template <typename Isa>
void costs_of(std::span<const std::uint8_t> left, std::span<const std::uint8_t> right, int bits,
              int lanes, std::span<std::uint8_t> costs) noexcept {
  STOF_CHECK(bits == kCensus5x5.bits() || bits == kCensus9x7.bits());
  STOF_CHECK(lanes > 0 && lanes % static_cast<int>(Isa::kLanes) == 0 && !costs.empty());
  const auto count = static_cast<std::size_t>(lanes);
  if (bits == kCensus5x5.bits()) {
    compare<Isa, planes_of(kCensus5x5.bits())>(left, right, count, costs);
  } else {
    compare<Isa, planes_of(kCensus9x7.bits())>(left, right, count, costs);
  }
}

}  // namespace stof::dsp::hamming_body
