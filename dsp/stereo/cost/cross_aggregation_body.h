#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

#include "dsp/base/check.h"
#include "dsp/stereo/cost/cross_aggregation.h"

// The vector variants of cross_aggregation.h. Isa: Lanes<std::uint8_t> of base/lanes_neon.h or
// lanes_avx2.h and
//   means(a, b, c, reciprocal)   of the sums of three vectors
namespace stof::dsp::cross_aggregation_body {

static constexpr std::array<std::uint8_t, 256> kZeros{};

// lanes a multiple of Isa::kLanes, at most 256.
template <typename Isa>
void sum_alike(std::span<const std::uint8_t> costs, std::span<const std::uint8_t> joined, int lanes,
               std::span<std::uint8_t> sums) noexcept {
  const auto step = static_cast<std::size_t>(lanes);
  STOF_CHECK(lanes % static_cast<int>(Isa::kLanes) == 0 && step <= kZeros.size() &&
             joined.front() == 0 && joined.back() == 0 &&
             costs.size() == (joined.size() - 1) * step && sums.size() == costs.size());
  for (std::size_t x = 0; x + 1 < joined.size(); ++x) {
    const std::uint8_t* const own = costs.data() + x * step;
    const std::uint8_t* const before = joined[x] != 0 ? own - step : kZeros.data();
    const std::uint8_t* const after = joined[x + 1] != 0 ? own + step : kZeros.data();
    std::uint8_t* const to = sums.data() + x * step;
    for (std::size_t i = 0; i < step; i += Isa::kLanes) {
      Isa::store(to + i, Isa::load(own + i) + Isa::load(before + i) + Isa::load(after + i));
    }
  }
}

// lanes a multiple of Isa::kLanes, at most 256. By value: no store changes the rows.
template <typename Isa>
void cross_means(CrossRows rows, int lanes, std::span<std::uint8_t> means) noexcept {
  const auto step = static_cast<std::size_t>(lanes);
  check_cross_rows(rows, lanes, means.size());
  STOF_CHECK(lanes % static_cast<int>(Isa::kLanes) == 0 && step <= kZeros.size());
  for (std::size_t x = 0; x < rows.areas.size(); ++x) {
    const std::size_t at = x * step;
    const std::uint8_t* const above =
        rows.with_above[x] != 0 ? rows.above.data() + at : kZeros.data();
    const std::uint8_t* const below =
        rows.with_below[x] != 0 ? rows.below.data() + at : kZeros.data();
    const std::uint8_t* const own = rows.here.data() + at;
    const std::int16_t reciprocal = rows.reciprocals[rows.areas[x]];
    std::uint8_t* const to = means.data() + at;
    for (std::size_t i = 0; i < step; i += Isa::kLanes) {
      Isa::store(to + i, Isa::means(Isa::load(above + i), Isa::load(own + i), Isa::load(below + i),
                                    reciprocal));
    }
  }
}

}  // namespace stof::dsp::cross_aggregation_body
