#include "dsp/stereo/prefilter/prefilter.h"

#include <algorithm>
#include <cstddef>

#include "dsp/base/check.h"

namespace stof::dsp {

void clipped_sobel_columns(std::span<const std::uint8_t> above, std::span<const std::uint8_t> here,
                           std::span<const std::uint8_t> below, int cap, std::size_t begin,
                           std::size_t end, std::span<std::uint8_t> out) noexcept {
  for (std::size_t x = begin; x < end; ++x) {
    const std::size_t before = x == 0 ? 0 : x - 1;
    const std::size_t after = x + 1 == here.size() ? x : x + 1;
    const int derivative = (above[after] - above[before]) + 2 * (here[after] - here[before]) +
                           (below[after] - below[before]);
    out[x] = static_cast<std::uint8_t>(std::clamp(derivative, -cap, cap) + cap);
  }
}

namespace ref {

void clipped_sobel(std::span<const std::uint8_t> above, std::span<const std::uint8_t> here,
                   std::span<const std::uint8_t> below, int cap,
                   std::span<std::uint8_t> out) noexcept {
  STOF_CHECK(above.size() == here.size() && below.size() == here.size() &&
             out.size() == here.size() && cap >= 1 && cap <= 127);
  clipped_sobel_columns(above, here, below, cap, 0, here.size(), out);
}

}  // namespace ref
}  // namespace stof::dsp
