#include "dsp/stereo/prefilter/smooth.h"

#include <algorithm>

#include "dsp/base/check.h"
#include "dsp/base/simd.h"

namespace stof::dsp::neon {

void binomial(std::span<const std::uint8_t> above, std::span<const std::uint8_t> here,
              std::span<const std::uint8_t> below, std::span<std::uint8_t> out) noexcept {
  const std::size_t n = here.size();
  STOF_CHECK(above.size() == n && below.size() == n && out.size() == n);
  // above + 2 here + below for eight columns.
  const auto columns = [&](std::size_t x) noexcept {
    const uint16x8_t middle = vmovl_u8(vld1_u8(here.data() + x));
    return vaddq_u16(vaddl_u8(vld1_u8(above.data() + x), vld1_u8(below.data() + x)),
                     vaddq_u16(middle, middle));
  };
  binomial_columns(above, here, below, 0, std::min<std::size_t>(n, 1), out);
  std::size_t x = 1;
  for (; x + 9 <= n; x += 8) {  // reads columns x - 1 .. x + 8
    const uint16x8_t middle = columns(x);
    const uint16x8_t sum =
        vaddq_u16(vaddq_u16(columns(x - 1), columns(x + 1)), vaddq_u16(middle, middle));
    vst1_u8(out.data() + x, vmovn_u16(vshrq_n_u16(vaddq_u16(sum, vdupq_n_u16(8)), 4)));
  }
  binomial_columns(above, here, below, std::min(x, n), n, out);
}

}  // namespace stof::dsp::neon
