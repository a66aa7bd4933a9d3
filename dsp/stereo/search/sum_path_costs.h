#pragma once

#include <cstdint>
#include <span>

#include "dsp/base/kernel.h"

namespace stof::dsp {

// sums[i] = the sum over 2 to 8 rows of paths (search/path_costs.h) of paths[k][i], saturated where
// Sum is u8. Each row has sums.size() elements, a multiple of 16; u16 paths are below 8192. No
// overlap.
template <typename Types>
using SumPathCosts = void(std::span<const typename Types::Cost* const> paths,
                          std::span<typename Types::Sum> sums) noexcept;
template <typename CostType, typename SumType>
struct PathTypes {
  using Cost = CostType;
  using Sum = SumType;
};
using BytesToBytes = PathTypes<std::uint8_t, std::uint8_t>;
using BytesToWords = PathTypes<std::uint8_t, std::uint16_t>;
using WordsToWords = PathTypes<std::uint16_t, std::uint16_t>;

STOF_KERNELS(SumPathCosts, sum_path_costs, Avx2<BytesToBytes>, Neon<BytesToWords>,
             Neon<WordsToWords>)

}  // namespace stof::dsp
