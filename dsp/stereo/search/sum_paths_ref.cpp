#include "dsp/stereo/search/sum_paths.h"

#include <algorithm>
#include <cstddef>
#include <limits>

#include "dsp/base/check.h"

namespace stof::dsp::ref {

template <typename Types>
void sum_paths(std::span<const typename Types::Cost* const> paths,
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

template SumPaths<BytesToBytes> sum_paths<BytesToBytes>;
template SumPaths<BytesToWords> sum_paths<BytesToWords>;
template SumPaths<WordsToWords> sum_paths<WordsToWords>;

}  // namespace stof::dsp::ref
