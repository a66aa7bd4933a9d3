#include "dsp/stereo/prefilter/smooth.h"

#include "dsp/base/check.h"

namespace stof::dsp {

void binomial_columns(std::span<const std::uint8_t> above, std::span<const std::uint8_t> here,
                      std::span<const std::uint8_t> below, std::size_t begin, std::size_t end,
                      std::span<std::uint8_t> out) noexcept {
  const auto column = [&](std::size_t x) noexcept { return above[x] + 2 * here[x] + below[x]; };
  for (std::size_t x = begin; x < end; ++x) {
    const std::size_t before = x == 0 ? 0 : x - 1;
    const std::size_t after = x + 1 == here.size() ? x : x + 1;
    out[x] = static_cast<std::uint8_t>((column(before) + 2 * column(x) + column(after) + 8) / 16);
  }
}

namespace ref {

void binomial(std::span<const std::uint8_t> above, std::span<const std::uint8_t> here,
              std::span<const std::uint8_t> below, std::span<std::uint8_t> out) noexcept {
  STOF_CHECK(above.size() == here.size() && below.size() == here.size() &&
             out.size() == here.size());
  binomial_columns(above, here, below, 0, here.size(), out);
}

}  // namespace ref
}  // namespace stof::dsp
