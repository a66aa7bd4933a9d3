#include "dsp/stereo/search/sum_path_costs.h"

#include <cstddef>

#include "dsp/base/avx2.h"
#include "dsp/base/check.h"

namespace stof::dsp::avx2 {
namespace {

constexpr std::size_t kStep = 32;

u8x32 add_saturated(u8x32 a, u8x32 b) noexcept {
  return as<u8x32>(_mm256_adds_epu8(bits(a), bits(b)));
}

// The last vector overlaps the one before it.
std::size_t next(std::size_t at, std::size_t size) noexcept {
  return at + kStep < size && at + 2 * kStep > size ? size - kStep : at + kStep;
}

}  // namespace

template <typename Types>
void sum_path_costs(std::span<const typename Types::Cost* const> paths,
                    std::span<typename Types::Sum> sums) noexcept {
  STOF_CHECK(paths.size() >= 2 && sums.size() % 16 == 0);
  if (sums.size() < kStep) {
    neon::sum_path_costs<Types>(paths, sums);
    return;
  }
  for (std::size_t i = 0; i < sums.size(); i = next(i, sums.size())) {
    u8x32 total = add_saturated(load<u8x32>(paths[0] + i), load<u8x32>(paths[1] + i));
    for (const typename Types::Cost* const path : paths.subspan(2)) {
      total = add_saturated(total, load<u8x32>(path + i));
    }
    store(sums.data() + i, total);
  }
}

STOF_INSTANTIATE(SumPathCosts, sum_path_costs, BytesToBytes);

}  // namespace stof::dsp::avx2
