#include "dsp/stereo/prefilter/smooth.h"

#include <cstddef>

#include "dsp/base/check.h"
#include "dsp/stereo/prefilter/column_sums_avx2.h"

namespace stof::dsp::avx2 {
namespace {

constexpr std::size_t kStep = 32;

u16x16 weighted(u16x16 before, u16x16 here, u16x16 after) noexcept {
  return (before + after + here + here + all(std::uint16_t{8})) >> 4;
}

}  // namespace

void binomial(std::span<const std::uint8_t> above, std::span<const std::uint8_t> here,
              std::span<const std::uint8_t> below, std::span<std::uint8_t> out) noexcept {
  const std::size_t n = here.size();
  STOF_CHECK(above.size() == n && below.size() == n && out.size() == n);
  if (n < kStep + 2) {
    neon::binomial(above, here, below, out);
    return;
  }
  binomial_columns(above, here, below, 0, 1, out);
  // Reads columns x - 1 .. x + 32; the last step overlaps the one before it.
  for (std::size_t x = 1; x + 1 < n; x += kStep) {
    x = x + kStep + 1 > n ? n - 1 - kStep : x;
    const auto sums = [&](std::size_t at) noexcept {
      return column_sums(above.data() + at, here.data() + at, below.data() + at);
    };
    const Words before = sums(x - 1);
    const Words middle = sums(x);
    const Words after = sums(x + 1);
    const u16x16 low = weighted(before.low, middle.low, after.low);
    const u16x16 high = weighted(before.high, middle.high, after.high);
    store(out.data() + x, as<u8x32>(_mm256_packus_epi16(bits(low), bits(high))));
  }
  binomial_columns(above, here, below, n - 1, n, out);
}

}  // namespace stof::dsp::avx2
