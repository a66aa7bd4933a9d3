#include "dsp/stereo/search/sum_paths.h"

#include <algorithm>
#include <cstddef>
#include <limits>

#include "dsp/base/check.h"

namespace stof::dsp::ref {
namespace {

template <typename Cost, typename Sum>
void sum(std::span<const Cost* const> paths, std::span<Sum> sums) noexcept {
  STOF_CHECK(paths.size() >= 2 && sums.size() % 16 == 0);
  for (std::size_t i = 0; i < sums.size(); ++i) {
    std::uint32_t total = 0;
    for (const Cost* const path : paths) {
      total += path[i];
    }
    sums[i] = static_cast<Sum>(std::min<std::uint32_t>(total, std::numeric_limits<Sum>::max()));
  }
}

}  // namespace

void sum_paths(std::span<const std::uint8_t* const> paths, std::span<std::uint8_t> sums) noexcept {
  sum(paths, sums);
}
void sum_paths(std::span<const std::uint8_t* const> paths, std::span<std::uint16_t> sums) noexcept {
  sum(paths, sums);
}
void sum_paths(std::span<const std::uint16_t* const> paths,
               std::span<std::uint16_t> sums) noexcept {
  sum(paths, sums);
}

}  // namespace stof::dsp::ref
