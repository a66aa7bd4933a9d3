#include "dsp/stereo/prefilter/prefilter.h"

#include <cstddef>

#include "dsp/base/check.h"
#include "dsp/stereo/prefilter/column_sums_avx2.h"

namespace stof::dsp::avx2 {
namespace {

constexpr std::size_t kStep = 32;

}  // namespace

void clipped_sobel(std::span<const std::uint8_t> above, std::span<const std::uint8_t> here,
                   std::span<const std::uint8_t> below, int cap,
                   std::span<std::uint8_t> out) noexcept {
  const std::size_t n = here.size();
  STOF_CHECK(above.size() == n && below.size() == n && out.size() == n && cap >= 1 && cap <= 127);
  if (n < kStep + 2) {
    neon::clipped_sobel(above, here, below, cap, out);
    return;
  }
  const i16x16 high = all(static_cast<std::int16_t>(cap));
  const auto clipped = [&](u16x16 after, u16x16 before) noexcept {
    const i16x16 derivative = as<i16x16>(bits(after - before));
    return smaller(larger(derivative, i16x16{} - high), high) + high;
  };
  clipped_sobel_columns(above, here, below, cap, 0, 1, out);
  // Reads columns x - 1 .. x + 32; the last step overlaps the one before it.
  for (std::size_t x = 1; x + 1 < n; x += kStep) {
    x = x + kStep + 1 > n ? n - 1 - kStep : x;
    const auto sums = [&](std::size_t at) noexcept {
      return column_sums(above.data() + at, here.data() + at, below.data() + at);
    };
    const Words after = sums(x + 1);
    const Words before = sums(x - 1);
    const i16x16 low = clipped(after.low, before.low);
    const i16x16 upper = clipped(after.high, before.high);
    store(out.data() + x, as<u8x32>(_mm256_packus_epi16(bits(low), bits(upper))));
  }
  clipped_sobel_columns(above, here, below, cap, n - 1, n, out);
}

}  // namespace stof::dsp::avx2
