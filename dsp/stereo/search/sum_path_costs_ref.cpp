#include "dsp/stereo/search/sum_path_costs.h"

#include <algorithm>
#include <cstddef>
#include <limits>

#include "dsp/base/check.h"

namespace stof::dsp::ref {

template <typename Types>
void sum_path_costs(std::span<const typename Types::Cost* const> paths,
                    std::span<typename Types::Sum> sums) noexcept {
  STOF_CHECK(paths.size() >= 2 && sums.size() % 16 == 0);
  for (std::size_t i = 0; i < sums.size(); ++i) {
    std::uint32_t total = 0;
    for (const typename Types::Cost* const path : paths) {
      total += path[i];
    }
    sums[i] = static_cast<typename Types::Sum>(
        std::min<std::uint32_t>(total, std::numeric_limits<typename Types::Sum>::max()));
  }
}

STOF_INSTANTIATE(SumPathCosts, sum_path_costs, BytesToBytes, BytesToWords, WordsToWords);

}  // namespace stof::dsp::ref
