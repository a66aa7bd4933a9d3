#pragma once

#include <cstddef>

#include "dsp/base/check.h"
#include "dsp/stereo/cost/ad_census.h"
#include "dsp/stereo/cost/hamming_body.h"

// The vector variants of ad_census.h. Isa: the Hamming of hamming_neon.h or hamming_avx2.h, and
// half(a), rounded down.
namespace stof::dsp::ad_census_body {

constexpr std::size_t kPlanes = planes_of(kCensus7x7.bits());

// The data of one pixel: a left column, or the first of its candidates.
struct Pixel {
  hamming_body::Planes planes;
  const std::uint8_t* grey;
  const std::uint8_t* derivative;

  Pixel(const AdCensusRow& row, std::size_t at) noexcept
      : planes{row.planes.data() + at, row.grey.size()},
        grey(row.grey.data() + at),
        derivative(row.derivative.data() + at) {}
};

template <typename Isa, std::size_t kVectors>
void strip(const Pixel& left, const Pixel& right, std::uint8_t* costs) noexcept {
  typename Isa::V sums[kVectors];
  Isa::template distances<kPlanes>(left.planes, right.planes, sums);
  const typename Isa::V grey = Isa::all(*left.grey);
  const typename Isa::V derivative = Isa::all(*left.derivative);
  for (std::size_t v = 0; v < kVectors; ++v) {
    const std::size_t at = Isa::kLanes * v;
    const typename Isa::V of_grey =
        Isa::smaller(Isa::difference(grey, Isa::load(right.grey + at)), Isa::all(kAdCensusGreyCap));
    const typename Isa::V of_derivative =
        Isa::smaller(Isa::difference(derivative, Isa::load(right.derivative + at)),
                     Isa::all(kAdCensusDerivativeCap));
    Isa::store(costs + at, sums[v] + sums[v] + Isa::half(of_grey + of_derivative));
  }
}

// lanes a multiple of Isa::kLanes. By value: no store changes the rows.
template <typename Isa>
void costs_of(AdCensusRow left, AdCensusRow right, int lanes,
              std::span<std::uint8_t> costs) noexcept {
  STOF_CHECK(lanes > 0 && lanes % static_cast<int>(Isa::kLanes) == 0 && !costs.empty());
  const std::size_t count = static_cast<std::size_t>(lanes);
  const std::size_t n = costs.size() / count;
  const std::size_t candidates = n + count - 1;
  STOF_CHECK(costs.size() == n * count && left.planes.size() == kPlanes * n &&
             right.planes.size() == kPlanes * candidates);
  STOF_CHECK(left.grey.size() == n && right.grey.size() == candidates);
  STOF_CHECK(left.derivative.size() == n && right.derivative.size() == candidates);
  for (std::size_t k = 0; k < n; ++k) {
    const Pixel own(left, k);
    const std::size_t first = n - 1 - k;
    std::uint8_t* const out = costs.data() + k * count;
    std::size_t i = 0;
    for (; i + 64 <= count; i += 64) {
      strip<Isa, 64 / Isa::kLanes>(own, Pixel(right, first + i), out + i);
    }
    for (; i < count; i += Isa::kLanes) {
      strip<Isa, 1>(own, Pixel(right, first + i), out + i);
    }
  }
}

}  // namespace stof::dsp::ad_census_body
