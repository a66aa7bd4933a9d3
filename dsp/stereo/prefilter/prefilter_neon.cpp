#include "dsp/stereo/prefilter/prefilter.h"

#include <algorithm>
#include <cstddef>

#include "dsp/base/check.h"
#include "dsp/base/simd.h"

namespace stof::dsp::neon {
namespace {

// row[x + 1] - row[x - 1] for eight columns.
int16x8_t difference(const std::uint8_t* row) noexcept {
  return vreinterpretq_s16_u16(vsubl_u8(vld1_u8(row + 1), vld1_u8(row - 1)));
}

}  // namespace

void clipped_sobel(std::span<const std::uint8_t> above, std::span<const std::uint8_t> here,
                   std::span<const std::uint8_t> below, int cap,
                   std::span<std::uint8_t> out) noexcept {
  const std::size_t n = here.size();
  STOF_CHECK(above.size() == n && below.size() == n && out.size() == n && cap >= 1 && cap <= 127);
  const int16x8_t high = vdupq_n_s16(static_cast<std::int16_t>(cap));
  const int16x8_t low = vnegq_s16(high);
  clipped_sobel_columns(above, here, below, cap, 0, std::min<std::size_t>(n, 1), out);
  std::size_t x = 1;
  for (; x + 9 <= n; x += 8) {  // reads columns x - 1 .. x + 8
    const int16x8_t middle = difference(here.data() + x);
    int16x8_t sum = vaddq_s16(difference(above.data() + x), difference(below.data() + x));
    sum = vaddq_s16(sum, vaddq_s16(middle, middle));
    const int16x8_t clipped = vaddq_s16(vmaxq_s16(vminq_s16(sum, high), low), high);
    vst1_u8(out.data() + x, vmovn_u16(vreinterpretq_u16_s16(clipped)));
  }
  clipped_sobel_columns(above, here, below, cap, std::min(x, n), n, out);
}

}  // namespace stof::dsp::neon
