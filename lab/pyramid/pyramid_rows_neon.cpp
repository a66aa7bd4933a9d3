#include "lab/pyramid/pyramid_rows.h"

#include <cstddef>

#include "dsp/base/check.h"
#include "dsp/base/simd.h"
#include "dsp/stereo/search/winner.h"

namespace stof::dsp::neon {
namespace {

static_assert(kNoWinner == -1);  // without a sign it is larger than every winner

int16x8_t between(int16x8_t a, int16x8_t b) noexcept {
  const uint16x8_t first = vreinterpretq_u16_s16(a);
  const uint16x8_t second = vreinterpretq_u16_s16(b);
  const uint16x8_t least = vminq_u16(first, second);
  const uint16x8_t apart = vsubq_u16(vmaxq_u16(first, second), least);
  const uint16x8_t step = vcgtq_u16(apart, vdupq_n_u16(1));
  return vreinterpretq_s16_u16(vbslq_u16(step, least, first));
}

}  // namespace

void halve_row(std::span<const std::uint8_t> upper, std::span<const std::uint8_t> lower,
               std::span<std::uint8_t> out) noexcept {
  STOF_CHECK(upper.size() == lower.size() && out.size() == (upper.size() + 1) / 2);
  const auto four = [&](std::size_t x) noexcept {
    const uint16x8_t sum = vpaddlq_u8(vld1q_u8(upper.data() + x));
    return vrshrn_n_u16(vpadalq_u8(sum, vld1q_u8(lower.data() + x)), 2);
  };
  std::size_t x = 0;
  for (; 2 * x + 32 <= upper.size(); x += 16) {
    vst1q_u8(out.data() + x, vcombine_u8(four(2 * x), four(2 * x + 16)));
  }
  ref::halve_row(upper.subspan(2 * x), lower.subspan(2 * x), out.subspan(x));
}

void between_rows(std::span<const std::int16_t> above, std::span<const std::int16_t> below,
                  std::span<std::int16_t> out) noexcept {
  STOF_CHECK(above.size() == out.size() && below.size() == out.size());
  std::size_t x = 0;
  for (; x + 8 <= out.size(); x += 8) {
    vst1q_s16(out.data() + x, between(vld1q_s16(above.data() + x), vld1q_s16(below.data() + x)));
  }
  ref::between_rows(above.subspan(x), below.subspan(x), out.subspan(x));
}

void spread_row(std::span<const std::int16_t> found, std::span<std::int16_t> out) noexcept {
  STOF_CHECK(found.size() == (out.size() + 1) / 2);
  std::size_t k = 0;
  for (; k + 9 <= found.size(); k += 8) {
    const int16x8_t here = vld1q_s16(found.data() + k);
    const int16x8_t middle = between(here, vld1q_s16(found.data() + k + 1));
    vst1q_s16(out.data() + 2 * k, vzip1q_s16(here, middle));
    vst1q_s16(out.data() + 2 * k + 8, vzip2q_s16(here, middle));
  }
  ref::spread_row(found.subspan(k), out.subspan(2 * k));
}

}  // namespace stof::dsp::neon
