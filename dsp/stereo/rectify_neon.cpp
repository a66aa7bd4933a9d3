#include "dsp/stereo/rectify.h"

#include <array>
#include <cstddef>
#include <cstring>

#include "dsp/base/check.h"
#include "dsp/base/simd.h"

namespace stof::dsp::neon {
namespace {

constexpr std::size_t kLanes = 8;

// Eight pairs of neighbours, mixed: 7 fraction bits.
int16x8_t mix_columns(const std::array<std::uint8_t, 2 * kLanes>& pairs,
                      int16x8_t fraction) noexcept {
  const uint8x8x2_t both = vld2_u8(pairs.data());
  const int16x8_t a = vreinterpretq_s16_u16(vshll_n_u8(both.val[0], kPlaceFractionBits));
  const int16x8_t step = vreinterpretq_s16_u16(vsubl_u8(both.val[1], both.val[0]));
  return vmlaq_s16(a, step, fraction);
}

}  // namespace

void remap_row(ImageView<const std::uint8_t> source, const RemapRow& places,
               std::span<std::uint8_t> out) noexcept {
  const std::size_t n = out.size();
  STOF_CHECK(places.x.size() == n && places.y.size() == n);
  STOF_CHECK(places.fraction_x.size() == n && places.fraction_y.size() == n);
  const std::uint8_t* const first = source.data();
  const std::ptrdiff_t stride = source.stride();
  const uint8x8_t fraction_bits = vdup_n_u8(kPlaceOne - 1);
  std::size_t i = 0;
  for (; i + kLanes <= n; i += kLanes) {
    std::array<std::uint8_t, 2 * kLanes> upper{};
    std::array<std::uint8_t, 2 * kLanes> lower{};
    for (std::size_t k = 0; k < kLanes; ++k) {  // NEON has no gather
      const std::uint8_t* const at = first + places.y[i + k] * stride + places.x[i + k];
      std::memcpy(&upper[2 * k], at, 2);
      std::memcpy(&lower[2 * k], at + stride, 2);
    }
    const int16x8_t fx = vreinterpretq_s16_u16(
        vmovl_u8(vand_u8(vld1_u8(places.fraction_x.data() + i), fraction_bits)));
    // As Q15: a doubling multiplication that keeps the rounded high half divides by 128.
    const int16x8_t fy =
        vreinterpretq_s16_u16(vshlq_n_u16(vmovl_u8(vld1_u8(places.fraction_y.data() + i)), 8));
    const int16x8_t above = mix_columns(upper, fx);
    const int16x8_t below = mix_columns(lower, fx);
    const int16x8_t mixed = vaddq_s16(above, vqrdmulhq_s16(vsubq_s16(below, above), fy));
    vst1_u8(out.data() + i, vqrshrun_n_s16(mixed, kPlaceFractionBits));
  }
  ref::remap_row(source,
                 {places.x.subspan(i), places.y.subspan(i), places.fraction_x.subspan(i),
                  places.fraction_y.subspan(i)},
                 out.subspan(i));
}

}  // namespace stof::dsp::neon
